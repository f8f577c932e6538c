// Writes the tree that Embree's rtcBuildBVH makes over triangles: embree TRIANGLES SLOTS OUT.npz, where TRIANGLES holds nine
// little-endian floats each. NpzWriter, from docs/tree-format.md, stands before this.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cstdlib>
#include <vector>

struct Item {
    // A leaf has shapes, a node children.
    std::vector<unsigned> shapes;
    std::vector<Item*> children;
    std::vector<RTCBounds> bounds;
};

static void* create_node(RTCThreadLocalAllocator, unsigned count, void*) {
    Item* item = new Item;
    item->bounds.resize(count);
    return item;
}

static void set_children(void* node, void** children, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) static_cast<Item*>(node)->children.push_back(static_cast<Item*>(children[i]));
}

static void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) static_cast<Item*>(node)->bounds[i] = *bounds[i];
}

static void* create_leaf(RTCThreadLocalAllocator, const RTCBuildPrimitive* primitives, size_t count, void*) {
    Item* item = new Item;
    for (size_t i = 0; i < count; ++i) item->shapes.push_back(primitives[i].primID);
    return item;
}

int main(int, char** arguments) {
    std::ifstream input(arguments[1], std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(input)), std::istreambuf_iterator<char>());
    const float* corners = reinterpret_cast<const float*>(bytes.data());
    const size_t count = bytes.size() / 36;
    std::vector<RTCBuildPrimitive> primitives(count);
    for (size_t i = 0; i < count; ++i) {
        float low[3], high[3];
        for (int axis = 0; axis < 3; ++axis) {
            const float a = corners[9 * i + axis], b = corners[9 * i + 3 + axis], c = corners[9 * i + 6 + axis];
            low[axis] = std::min(a, std::min(b, c));
            high[axis] = std::max(a, std::max(b, c));
        }
        primitives[i] = {low[0], low[1], low[2], 0, high[0], high[1], high[2], unsigned(i)};
    }
    const size_t slots = std::strtoul(arguments[2], nullptr, 10);
    RTCDevice device = rtcNewDevice("threads=1");
    RTCBVH bvh = rtcNewBVH(device);
    RTCBuildArguments build = rtcDefaultBuildArguments();
    build.maxBranchingFactor = unsigned(slots);
    build.maxLeafSize = 4;
    build.bvh = bvh;
    build.primitives = primitives.data();
    build.primitiveCount = build.primitiveArrayCapacity = count;
    build.createNode = create_node;
    build.setNodeChildren = set_children;
    build.setNodeBounds = set_bounds;
    build.createLeaf = create_leaf;
    Item* root = static_cast<Item*>(rtcBuildBVH(&build));
    if (!root) return 1;

    std::vector<float> child_min, child_max;
    std::vector<int32_t> child_index, leaf_first, leaf_count, shape_index;
    std::vector<Item*> nodes;
    auto number = [&](Item* item) -> int32_t {
        if (!item->children.empty()) {
            nodes.push_back(item);
            return int32_t(nodes.size() - 1);
        }
        leaf_first.push_back(int32_t(shape_index.size()));
        leaf_count.push_back(int32_t(item->shapes.size()));
        shape_index.insert(shape_index.end(), item->shapes.begin(), item->shapes.end());
        return -2 - int32_t(leaf_first.size() - 1);
    };
    number(root);
    for (size_t at = 0; at < nodes.size(); ++at) {
        Item* node = nodes[at];
        for (size_t slot = 0; slot < slots; ++slot) {
            const bool filled = slot < node->children.size();
            const RTCBounds b = filled ? node->bounds[slot] : RTCBounds{};
            child_min.insert(child_min.end(), {b.lower_x, b.lower_y, b.lower_z});
            child_max.insert(child_max.end(), {b.upper_x, b.upper_y, b.upper_z});
            child_index.push_back(filled ? number(node->children[slot]) : -1);
        }
    }
    const std::string n = std::to_string(nodes.size()), k = std::to_string(slots);
    const std::string leaves = "(" + std::to_string(leaf_first.size()) + ",)";
    NpzWriter npz(arguments[3]);
    npz.add("child_min", "<f4", "(" + n + ", " + k + ", 3)", child_min.data(), child_min.size() * 4);
    npz.add("child_max", "<f4", "(" + n + ", " + k + ", 3)", child_max.data(), child_max.size() * 4);
    npz.add("child_index", "<i4", "(" + n + ", " + k + ")", child_index.data(), child_index.size() * 4);
    npz.add("leaf_first", "<i4", leaves, leaf_first.data(), leaf_first.size() * 4);
    npz.add("leaf_count", "<i4", leaves, leaf_count.data(), leaf_count.size() * 4);
    npz.add("shape_index", "<i4", "(" + std::to_string(shape_index.size()) + ",)", shape_index.data(), shape_index.size() * 4);
    npz.add("triangles", "<f4", "(" + std::to_string(count) + ", 3, 3)", corners, bytes.size());
    npz.finish();
}

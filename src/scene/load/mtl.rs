//! MTL material files through `tobj`, and what their values mean here.

use std::io::BufReader;

use glam::Vec3;

use super::fault::{counted, guarded};
use super::texture::Textures;
use crate::scene::{Color, Material, MaterialKind};

/// The index of refraction where none is given, or one that would bend nothing.
const DEFAULT_IOR: f32 = 1.5;
/// Materials more opaque than this are.
const OPAQUE: f32 = 0.99;

/// Reads the materials of the file called `name`; what makes no sense in it is left out, with a warning.
pub(super) fn read(bytes: &[u8], name: &str, warnings: &mut Vec<String>) -> Vec<tobj::Material> {
    let text = prepare(&String::from_utf8_lossy(bytes), name, warnings);
    match guarded("MTL", || tobj::load_mtl_buf(&mut BufReader::new(text.as_bytes()))) {
        Ok(Ok((materials, _))) => materials,
        Ok(Err(error)) => {
            warnings
                .push(format!("material file {name} cannot be read ({error}); its materials are shown grey"));
            Vec::new()
        }
        Err(_) => {
            warnings.push(format!("material file {name} is damaged; its materials are shown grey"));
            Vec::new()
        }
    }
}

/// The text without what `tobj` fails or panics on: `Kd` with fewer than three numbers, empty names, numbers that are none.
fn prepare(text: &str, name: &str, warnings: &mut Vec<String>) -> String {
    let mut clean = String::with_capacity(text.len());
    let (mut bad, mut first_bad) = (0, 0);
    for (line, number) in text.lines().zip(1_usize..) {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { continue };
        let rest = line.trim_start()[keyword.len()..].trim();
        let mut numbers = words.map_while(|w| w.parse::<f32>().ok().filter(|n| n.is_finite()));
        let kept = match keyword {
            "Ka" | "Kd" | "Ks" | "Ke" | "Tf" => match [numbers.next(), numbers.next(), numbers.next()] {
                [Some(r), Some(g), Some(b)] => Some(format!("{r} {g} {b}")),
                // A single number stands for all three.
                [Some(r), None, None] => Some(format!("{r} {r} {r}")),
                _ => None,
            },
            "Ns" | "Ni" | "Tr" | "Pm" | "Pr" => numbers.next().map(|n| n.to_string()),
            "d" => rest.trim_start_matches("-halo").trim().parse::<f32>().ok().map(|n| n.to_string()),
            "illum" => numbers.next().filter(|n| (0.0..=10.0).contains(n)).map(|n| (n as u8).to_string()),
            _ if keyword.starts_with('#') => continue,
            _ => (!rest.is_empty()).then(|| rest.to_owned()),
        };
        match kept {
            Some(kept) => clean.extend([keyword, " ", &kept, "\n"]),
            None => {
                first_bad = if bad == 0 { number } else { first_bad };
                bad += 1;
            }
        }
    }
    if bad > 0 {
        let lines = counted(bad, "line");
        warnings.push(format!(
            "{lines} of {name} left out, with values that make no sense (the first is line {first_bad})"
        ));
    }
    clean
}

/// What a material of the file means here: `Ke` shines; `illum` 3, 5 and 8 mirror; `illum` 4, 6, 7 and 9 or `d` below 1
/// are glass of index `Ni`; everything else is matt, coloured by `Kd` times `map_Kd`.
pub(super) fn material(material: &tobj::Material, textures: &mut Textures) -> Material {
    let color = |c: Option<[f32; 3]>| c.map(|c| Vec3::from_array(c).max(Vec3::ZERO));
    let parameter = |name: &str| material.unknown_param.get(name).map(String::as_str);
    let number = |name: &str| parameter(name).and_then(|text| text.parse::<f32>().ok());
    let texture = material.diffuse_texture.as_deref().and_then(texture_name);
    let diffuse = color(material.diffuse);
    let emitted = color(material.emissive).filter(|ke| ke.max_element() > 0.0);
    let opacity = material.dissolve.or(number("Tr").map(|tr| 1.0 - tr)).unwrap_or(1.0);
    // Cut-outs such as leaves say how opaque they are in an image, which is not looked at.
    let has_cut_out = material.dissolve_texture.is_some() || texture.is_some();
    let illum = material.illumination_model.unwrap_or(2);
    let is_metal = number("Pm").is_some_and(|pm| pm > 0.9) && number("Pr").is_some_and(|pr| pr < 0.2);

    let (color, kind) = if let Some(radiance) = emitted {
        (Color::Solid(diffuse.unwrap_or(Vec3::ONE)), MaterialKind::Emissive { radiance })
    } else if matches!(illum, 4 | 6 | 7 | 9) || (opacity < OPAQUE && !has_cut_out) {
        let ior = material.optical_density.filter(|n| *n > 1.01 && *n < 10.0).unwrap_or(DEFAULT_IOR);
        let filter = parameter("Tf").and_then(three_numbers).unwrap_or(Vec3::ONE);
        (Color::Solid(filter.min(Vec3::ONE)), MaterialKind::Glass { ior, absorption: Vec3::ZERO })
    } else if matches!(illum, 3 | 5 | 8) || is_metal {
        let specular = color(material.specular).filter(|ks| ks.max_element() > 0.01 && !is_metal);
        let reflected = specular.or(diffuse.filter(|kd| kd.max_element() > 0.01)).unwrap_or(Vec3::ONE);
        (Color::Solid(reflected.min(Vec3::ONE)), MaterialKind::Mirror)
    } else {
        let matt = MaterialKind::Diffuse { reflectivity: 0.0 };
        match texture {
            // Black would hide the image; writers that give both mean the image.
            Some(name) => {
                let tint = diffuse.filter(|kd| kd.max_element() > 0.0).unwrap_or(Vec3::ONE).min(Vec3::ONE);
                (Color::Image { image: textures.request(&name), tint }, matt)
            }
            None => (Color::Solid(diffuse.unwrap_or(Vec3::splat(0.7)).min(Vec3::ONE)), matt),
        }
    };
    Material { name: material.name.clone(), color, kind }
}

fn three_numbers(text: &str) -> Option<Vec3> {
    let mut numbers = text.split_whitespace().map_while(|w| w.parse::<f32>().ok());
    Some(Vec3::new(numbers.next()?, numbers.next()?, numbers.next()?).max(Vec3::ZERO))
}

/// The file name in a `map_Kd` line, behind its options.
fn texture_name(text: &str) -> Option<String> {
    let mut rest = text.trim();
    while let Some(option) = rest.split_whitespace().next().filter(|word| word.starts_with('-')) {
        let (least, most) = match option {
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-bm" | "-boost" | "-imfchan" | "-texres"
            | "-type" => (1, 1),
            "-mm" => (2, 2),
            "-o" | "-s" | "-t" => (1, 3),
            // A file name may begin with a dash.
            _ => break,
        };
        rest = rest[option.len()..].trim_start();
        for i in 0..most {
            let word = rest.split_whitespace().next()?;
            if i >= least && word.parse::<f32>().is_err() {
                break;
            }
            rest = rest[word.len()..].trim_start();
        }
    }
    (!rest.is_empty()).then(|| rest.to_owned())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The materials of an MTL text, and the warnings.
    fn parse(text: &str) -> (Vec<Material>, Vec<String>) {
        let mut warnings = Vec::new();
        let read = read(text.as_bytes(), "a.mtl", &mut warnings);
        let mut textures = Textures::new(Path::new(""));
        (read.iter().map(|m| material(m, &mut textures)).collect(), warnings)
    }

    fn kind(body: &str) -> MaterialKind {
        let (materials, warnings) = parse(&format!("newmtl a\n{body}"));
        assert_eq!(warnings, Vec::<String>::new(), "{body}");
        materials[0].kind
    }

    #[test]
    fn values_mean_what_users_of_the_format_expect() {
        let matt = MaterialKind::Diffuse { reflectivity: 0.0 };
        let glass = |ior| MaterialKind::Glass { ior, absorption: Vec3::ZERO };
        for (body, expected) in [
            ("Kd 0.5 0.5 0.5\n", matt),
            ("illum 2\nKs 1 1 1\nNs 200\n", matt),
            ("Ke 0 0 0\nd 1\nTr 0\n", matt),
            ("Ke 3 2 1\n", MaterialKind::Emissive { radiance: Vec3::new(3.0, 2.0, 1.0) }),
            ("illum 3\n", MaterialKind::Mirror),
            ("illum 5\n", MaterialKind::Mirror),
            ("Pm 1\nPr 0.05\n", MaterialKind::Mirror),
            ("illum 7\nNi 1.33\n", glass(1.33)),
            ("d 0.2\n", glass(1.5)),
            ("d 0.2\nNi 1\n", glass(1.5)),
            ("Tr 0.7\nNi 1.7\n", glass(1.7)),
            ("d 0.5\nmap_d leaf.png\n", matt),
        ] {
            assert_eq!(kind(body), expected, "{body}");
        }
    }

    #[test]
    fn colours_are_those_of_the_file() {
        let (materials, _) = parse("newmtl a\nKd 0.1 0.2 0.3\nnewmtl b\nillum 3\nKd 0 0 0\nKs 0.9 0.8 0.7\n");
        assert_eq!(materials[0].color, Color::Solid(Vec3::new(0.1, 0.2, 0.3)));
        assert_eq!(materials[1].color, Color::Solid(Vec3::new(0.9, 0.8, 0.7)));
        assert_eq!((materials[0].name.as_str(), materials[1].name.as_str()), ("a", "b"));
    }

    #[test]
    fn what_makes_no_sense_is_counted_and_left_out() {
        let (materials, warnings) =
            parse("newmtl a\nKd 0.5\nKs\nKe nan 1 1\nd x\nillum 99\nNi\nmap_Kd\n\nnewmtl\n# end");
        assert_eq!(materials.len(), 1);
        assert_eq!(materials[0].color, Color::Solid(Vec3::splat(0.5)));
        assert_eq!(warnings.len(), 1);
        assert!(warnings[0].contains("7 lines of a.mtl") && warnings[0].contains("line 3"), "{warnings:?}");
    }

    #[test]
    fn options_before_a_texture_are_skipped() {
        for (text, name) in [
            ("wood.png", "wood.png"),
            ("-s 2 2 1 wood.png", "wood.png"),
            ("-s 2 my wood.png", "my wood.png"),
            ("-clamp on -o 0 0 dir\\wood.png", "dir\\wood.png"),
            ("-bm 0.3 -mm 0 1 wood.png", "wood.png"),
            ("-odd-name.png", "-odd-name.png"),
        ] {
            assert_eq!(texture_name(text).as_deref(), Some(name));
        }
        assert_eq!(texture_name("-clamp on"), None);
    }
}

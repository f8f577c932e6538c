//! Points of a sweep as files: for programs, and for a later sweep that goes on from them.
//!
//! A line (CSV) or an object (JSON) a point: every column under its key, then `pareto_front`, the flags that build the tree
//! (`build_flags`) and what it was measured on (`question`). A point answers another sweep only if that question is the
//! same, word by word.

use std::path::Path;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use serde_json::{Map, Value as Json};

use super::table::{csv_text, pretty};
use super::{ExportError, atomic};
use crate::accel::BuildConfig;
use crate::inspect::best::Best;
use crate::inspect::columns::{COLUMNS, Column, Value};
use crate::inspect::compare::ComparedFigure;
use crate::inspect::sweep::SweepPoint;
use crate::scene::Camera;
use crate::session::{Session, Variant, flags};

/// The keys behind those of the columns.
const FRONT: &str = "pareto_front";
const BUILD: &str = "build_flags";
const QUESTION: &str = "question";

/// What points are measured on: scene, moment, camera, rays, and the costs that figures are taken under.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// With nothing in it that changes no figure.
    session: Session,
    camera: Camera,
}

/// What a file of points holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeptPoints {
    /// Those that answer the question.
    pub points: Vec<SweepPoint>,
    /// How many others there are.
    pub others: usize,
}

/// By the ending of a file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointsFormat {
    Csv,
    Json,
}

impl Question {
    /// That of a session whose scene is open.
    pub fn new(session: &Session, camera: &Camera) -> Self {
        let Session { scene, time, ground, up, count, render, .. } = session.clone();
        let build = session.build();
        let build = BuildConfig {
            traversal_cost: build.traversal_cost,
            intersection_cost: build.intersection_cost,
            ..BuildConfig::default()
        };
        let variants = vec![Variant { name: String::new(), build, ..Variant::default() }];
        let render = crate::render::RenderSettings { spp: None, ..render };
        let camera = *camera;
        let session = Session {
            scene,
            time,
            ground,
            up,
            count,
            render,
            camera: Some(camera),
            variants,
            ..Session::default()
        };
        Self { session, camera }
    }

    /// C_t and C_i of all figures.
    pub fn costs(&self) -> [f32; 2] {
        let build = self.session.build();
        [build.traversal_cost, build.intersection_cost]
    }

    /// In words that are the same for the same question. A file's scene is told by its content.
    pub fn text(&self) -> String {
        let scene = &self.session.scene;
        let scene = match &*scene.content_hash {
            "" => scene.reference.text(),
            hash => format!("sha256:{hash}"),
        };
        let version = env!("CARGO_PKG_VERSION");
        format!("bvhscope {version}, {scene} {}", flags::flag_words(&self.session).join(" "))
    }
}

impl PointsFormat {
    /// # Errors
    /// [`ExportError::Write`] for any ending but `.csv` and `.json`.
    pub fn of(path: &Path) -> Result<Self, ExportError> {
        match path.extension().unwrap_or_default().to_string_lossy().to_lowercase().as_str() {
            "csv" => Ok(Self::Csv),
            "json" => Ok(Self::Json),
            other => Err(ExportError::Write {
                path: path.to_owned(),
                reason: format!("the extension '{other}' is unknown; use .csv or .json"),
            }),
        }
    }
}

/// A line a point under the keys. `front`: the points on the Pareto front.
pub fn csv(points: &[SweepPoint], front: &[usize], question: &Question) -> String {
    let keys = COLUMNS.iter().map(|c| c.key).chain([FRONT, BUILD, QUESTION]).map(str::to_owned).collect();
    let question = question.text();
    let lines = points.iter().enumerate().map(|(i, point)| {
        let values = COLUMNS.iter().map(|c| c.value(point).plain());
        let own = [front.contains(&i).to_string(), build_flags(&point.config), question.clone()];
        values.chain(own).collect()
    });
    csv_text(keys, lines)
}

/// An object a point.
pub fn json(points: &[SweepPoint], front: &[usize], question: &Question) -> String {
    let records: Vec<_> = points
        .iter()
        .enumerate()
        .map(|(i, point)| PointRecord { point, front: Some(front.contains(&i)), question })
        .collect();
    pretty(&records)
}

/// Writes points to a file, whole or not at all.
///
/// # Errors
/// [`ExportError::Write`]
pub fn save(
    path: &Path,
    points: &[SweepPoint],
    front: &[usize],
    question: &Question,
) -> Result<(), ExportError> {
    let text = match PointsFormat::of(path)? {
        PointsFormat::Csv => csv(points, front, question),
        PointsFormat::Json => json(points, front, question),
    };
    atomic::write_bytes(path, text.as_bytes())
}

/// Reads the points of a file that answer a question.
///
/// # Errors
/// [`ExportError::Read`] that says what is wrong, and where.
pub fn open(path: &Path, question: &Question) -> Result<KeptPoints, ExportError> {
    let fail = |reason: String| ExportError::Read { path: path.to_owned(), reason };
    let format = PointsFormat::of(path)
        .map_err(|_| fail("points are kept in files that end in .csv or .json".to_owned()))?;
    let bytes = std::fs::read(path).map_err(|error| fail(error.to_string()))?;
    let records = match format {
        PointsFormat::Csv => csv_records(&bytes),
        PointsFormat::Json => json_records(&bytes),
    };
    kept(&records.map_err(fail)?, &question.text()).map_err(fail)
}

/// What a search found: the verdict, the winner, the default, every difference, and every tree that was tried.
pub fn best_json(best: &Best, front: &[usize], question: &Question) -> String {
    struct Differences(Vec<ComparedFigure>);
    impl Serialize for Differences {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            serializer.collect_map(self.0.iter().map(|row| (row.column.key, row)))
        }
    }
    #[derive(Serialize)]
    struct Whole<'a> {
        objective: &'static str,
        frames: u32,
        verdict: crate::inspect::best::Verdict,
        sentence: String,
        gain_percent: Option<f64>,
        settled: bool,
        best: PointRecord<'a>,
        default: PointRecord<'a>,
        differences: Differences,
        tried: Vec<PointRecord<'a>>,
    }
    let record = |point| PointRecord { point, front: None, question };
    let tried = best.tried.iter().enumerate();
    pretty(&Whole {
        objective: best.search.objective.name(),
        frames: best.search.frames,
        verdict: best.verdict,
        sentence: best.sentence(),
        gain_percent: best.gain_percent(),
        settled: best.settled,
        best: record(&best.best),
        default: record(&best.default),
        differences: Differences(best.gains()),
        tried: tried
            .map(|(i, point)| PointRecord { front: Some(front.contains(&i)), ..record(point) })
            .collect(),
    })
}

struct PointRecord<'a> {
    point: &'a SweepPoint,
    front: Option<bool>,
    question: &'a Question,
}

impl Serialize for PointRecord<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for column in COLUMNS {
            map.serialize_entry(column.key, &column.value(self.point))?;
        }
        if let Some(front) = self.front {
            map.serialize_entry(FRONT, &front)?;
        }
        map.serialize_entry(BUILD, &build_flags(&self.point.config))?;
        map.serialize_entry(QUESTION, &self.question.text())?;
        map.serialize_entry("settings", &self.question.session.render)?;
        map.serialize_entry("camera", &self.question.camera)?;
        map.end()
    }
}

/// The flags that build a tree, as far as they differ from the defaults.
pub fn build_flags(config: &BuildConfig) -> String {
    let mut session = Session::default();
    *session.build_mut() = *config;
    flags::flag_words(&session).join(" ")
}

fn config_of(text: &str) -> Result<BuildConfig, String> {
    let mut session = Session::default();
    let words: Vec<_> = text.split_whitespace().map(str::to_owned).collect();
    flags::read_words(&mut session, &words).map_err(|error| error.to_string())?;
    session.build().check().map_err(|error| error.to_string())?;
    Ok(*session.build())
}

/// A point as it stands in a file: values under their keys.
type Record = Map<String, Json>;

fn json_records(bytes: &[u8]) -> Result<Vec<Record>, String> {
    serde_json::from_slice(bytes).map_err(|error| format!("these are no points of a sweep: {error}"))
}

fn csv_records(bytes: &[u8]) -> Result<Vec<Record>, String> {
    let mut reader = ::csv::Reader::from_reader(bytes);
    let say = |error: ::csv::Error| format!("these are no points of a sweep: {error}");
    let keys = reader.headers().map_err(say)?.clone();
    let record = |line: Result<::csv::StringRecord, ::csv::Error>| {
        let line = line.map_err(say)?;
        let cell = |(key, text): (&str, &str)| (key.to_owned(), Json::String(text.to_owned()));
        Ok(keys.iter().zip(&line).map(cell).collect())
    };
    reader.records().map(record).collect()
}

fn kept(records: &[Record], question: &str) -> Result<KeptPoints, String> {
    let mut kept = KeptPoints::default();
    for (i, record) in records.iter().enumerate() {
        let say = |reason: String| format!("point {} (counted from 1): {reason}", i + 1);
        let text = |key: &str| match record.get(key) {
            Some(Json::String(text)) => Ok(text),
            _ => Err(say(format!("it has no '{key}'; only files that bvhscope sweep wrote have it"))),
        };
        if text(QUESTION)? != question {
            kept.others += 1;
            continue;
        }
        let config = config_of(text(BUILD)?).map_err(|reason| say(format!("{BUILD}: {reason}")))?;
        kept.points.push(SweepPoint::from_values(config, |column| value(record, column)));
    }
    Ok(kept)
}

/// A value as it was written; missing where it cannot be read.
fn value(record: &Record, column: &Column) -> Value {
    let number = |text: &str| match text.parse() {
        Ok(count) => Value::Count(count),
        Err(_) => text.parse::<f64>().map_or(Value::Missing, Value::from),
    };
    match record.get(column.key) {
        Some(Json::String(text)) if column.is_text() => Value::Text(text.clone()),
        Some(Json::String(text)) => number(text),
        Some(Json::Number(found)) => found.as_u64().map_or_else(|| found.as_f64().into(), Value::Count),
        _ => Value::Missing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{Builder, StopRule, Width};
    use crate::inspect::columns::Row;
    use crate::inspect::stats::TreeStats;
    use crate::render::CountKind;

    fn points() -> Vec<SweepPoint> {
        let mut odd = TreeStats::example("8 bins, leaf \"3\"");
        odd.config = BuildConfig {
            builder: Builder::Spatial,
            width: Width::W4,
            stop: StopRule::Cost,
            bins: 8,
            split_alpha: 0.1,
            traversal_cost: 0.3,
            ..BuildConfig::default()
        };
        odd.build_ms = 0.1 + 0.2;
        odd.rays.ray_cost_mean = Some(12.0);
        odd.times =
            Some(crate::render::measure::FrameTimes { traversal_ms: 1.5, frames_per_s: 30.0, threads: 2 });
        vec![SweepPoint::of(&TreeStats::example("A")), SweepPoint::of(&odd)]
    }

    fn question() -> Question {
        Question::new(&Session::default(), &Camera::default())
    }

    #[test]
    fn points_come_back_from_both_formats_as_they_were() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["points.csv", "points.json", "POINTS.CSV"] {
            let path = folder.path().join(name);
            save(&path, &points(), &[1], &question()).expect("written");
            let kept = open(&path, &question()).expect("read");
            assert_eq!((kept.points.len(), kept.others), (2, 0));
            for (kept, point) in kept.points.iter().zip(points()) {
                assert_eq!(kept.config, point.config);
                for column in COLUMNS {
                    let (kept, point) = (kept.value(column), point.value(column));
                    assert_eq!(kept.number(), point.number(), "{} in {name}", column.key);
                    assert_eq!(kept.plain(), point.plain(), "{} in {name}", column.key);
                }
            }
        }
    }

    #[test]
    fn another_scene_camera_size_or_cost_is_another_question() {
        let session = Session::default();
        let camera = Camera::default();
        let base = Question::new(&session, &camera).text();
        let with = |change: fn(&mut Session)| {
            let mut session = session.clone();
            change(&mut session);
            Question::new(&session, &camera).text()
        };
        for change in [
            (|s| s.scene.content_hash = "abc".to_owned()) as fn(&mut Session),
            |s| s.time = 0.5,
            |s| s.ground = true,
            |s| s.count = CountKind::All,
            |s| s.render.width = 7,
            |s| s.render.max_depth = 3,
            |s| s.build_mut().traversal_cost = 2.0,
        ] {
            assert_ne!(base, with(change));
        }
        let moved = Camera { fov_y_degrees: 20.0, ..camera };
        assert_ne!(base, Question::new(&session, &moved).text());
        for change in [
            (|s| s.build_mut().bins = 7) as fn(&mut Session),
            |s| s.view = crate::render::View::RayCost,
            |s| s.render.spp = Some(5),
        ] {
            assert_eq!(base, with(change), "no figure depends on it");
        }
    }

    #[test]
    fn points_of_other_questions_are_counted_and_left_out() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("points.csv");
        save(&path, &points(), &[], &question()).expect("written");
        let session = Session { count: CountKind::All, ..Session::default() };
        let kept = open(&path, &Question::new(&session, &Camera::default())).expect("read");
        assert_eq!((kept.points.len(), kept.others), (0, 2));
    }

    #[test]
    fn what_is_no_file_of_points_says_so() {
        let folder = tempfile::tempdir().expect("a folder");
        let written = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).expect("written");
            path
        };
        let text = question().text();
        for (path, part) in [
            (written("a.csv", "name,bins\nA,4\n"), "point 1 (counted from 1): it has no 'question'"),
            (written("b.json", "{"), "these are no points of a sweep"),
            (written("c.json", "[{\"question\": 7}]"), "it has no 'question'"),
            (written("d.txt", ""), "end in .csv or .json"),
            (folder.path().join("none.csv"), "No such file"),
            (
                written("e.csv", &format!("question,build_flags\n\"{text}\",--bins 999\n")),
                "--bins '999': allowed is a whole number from 2 to 256",
            ),
            (written("f.csv", &format!("question,build_flags\n\"{text}\",--bin 9\n")), "no flag --bin"),
            (written("g.csv", "question,build_flags\na,b,c\n"), "these are no points"),
        ] {
            let message = open(&path, &question()).expect_err(part).to_string();
            assert!(message.starts_with("cannot read ") && message.contains(part), "{message}");
        }
        assert!(save(&folder.path().join("x.png"), &[], &[], &question()).is_err());
    }

    #[test]
    fn build_flags_say_every_setting() {
        let config = points()[1].config;
        assert_eq!(config_of(&build_flags(&config)), Ok(config));
        assert_eq!(build_flags(&BuildConfig::default()), "");
        assert_eq!(config_of(""), Ok(BuildConfig::default()));
    }
}

//! The settings as flags: names, help, choices, how a session's value is written and how it is read. The command line,
//! its help, *Copy command* and the checks of a session's file are derived from the one table in [`super::flag_table`].

use std::path::Path;

use super::Session;
use super::flag_table::FLAGS;
pub use super::values::Choice;
use crate::scene::SceneRef;
use crate::scene::load::TreeFormat;

/// Why a flag's value was refused: which flag, what was given, what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlagError {
    #[error("there is no flag --{flag}")]
    UnknownFlag { flag: String },
    #[error("--{flag} '{value}': {reason}")]
    Value { flag: &'static str, value: String, reason: String },
}

/// Under which heading `--help` lists a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlagGroup {
    Tree,
    Scene,
    Picture,
    Display,
    Boxes,
}

impl FlagGroup {
    pub fn name(self) -> &'static str {
        match self {
            Self::Tree => "Tree",
            Self::Scene => "Scene and camera",
            Self::Picture => "Picture",
            Self::Display => "Display",
            Self::Boxes => "Boxes",
        }
    }
}

/// One flag.
pub struct Flag {
    /// Without the dashes.
    pub name: &'static str,
    /// `NAME`, `N`, `WxH` ...; `None` for a switch, whose values are `on` and `off`.
    pub value_name: Option<&'static str>,
    pub group: FlagGroup,
    pub help: &'static str,
    /// The choices of a closed set; empty for every other flag.
    pub choices: fn() -> Vec<Choice>,
    pub(super) set: fn(&mut Session, &str) -> Result<(), String>,
    pub(super) get: fn(&Session) -> String,
}

impl Flag {
    /// Sets what the text says.
    ///
    /// # Errors
    /// [`FlagError::Value`]; the session is then as before.
    pub fn read(&self, session: &mut Session, text: &str) -> Result<(), FlagError> {
        (self.set)(session, text).map_err(|reason| FlagError::Value {
            flag: self.name,
            value: text.to_owned(),
            reason,
        })
    }

    /// The text that [`Flag::read`] takes back, exactly.
    pub fn write(&self, session: &Session) -> String {
        (self.get)(session)
    }

    pub fn is_switch(&self) -> bool {
        self.value_name.is_none()
    }
}

/// Every flag, in the order of `--help`.
pub fn flags() -> &'static [Flag] {
    FLAGS
}

/// The flag of that name, given without dashes.
///
/// # Errors
/// [`FlagError::UnknownFlag`]
pub fn find(name: &str) -> Result<&'static Flag, FlagError> {
    flags().iter().find(|f| f.name == name).ok_or_else(|| FlagError::UnknownFlag { flag: name.to_owned() })
}

/// `bvhscope render SCENE --out FILE` with every flag that differs from the default: the command that makes the same
/// picture without a window. Quoted for a POSIX shell. Of several variants it names the active one.
pub fn command_line(session: &Session, out: &str) -> String {
    command(session, "render", &["--out", out])
}

/// `bvhscope NAME SCENE` with further words and every flag that differs from the default, as [`command_line`].
pub fn command(session: &Session, name: &str, more: &[&str]) -> String {
    let mut words = vec!["bvhscope".to_owned(), name.to_owned()];
    words.push(scene_word(&session.scene.reference));
    words.extend(more.iter().map(|word| (*word).to_owned()));
    words.extend(flag_words(session));
    if let (SceneRef::File(path), None) = (&session.scene.reference, session.tree())
        && TreeFormat::of(path).is_some()
    {
        // The shapes of a tree's file with another tree.
        words.extend(["--tree".to_owned(), "none".to_owned()]);
    }
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// `--flag value` for every setting that differs from the default, unquoted.
pub fn flag_words(session: &Session) -> Vec<String> {
    let default = Session::default();
    let mut words = Vec::new();
    for flag in flags() {
        let value = flag.write(session);
        if value == flag.write(&default) {
            continue;
        }
        if flag.is_switch() {
            // A switch takes its value behind an equals sign only; `on` may go without.
            words.push(if value == "on" {
                format!("--{}", flag.name)
            } else {
                format!("--{}={value}", flag.name)
            });
        } else {
            words.extend([format!("--{}", flag.name), value]);
        }
    }
    words
}

/// Sets what words like those of [`flag_words`] say.
///
/// # Errors
/// [`FlagError`] of the first word that is none; the session then has what the words before it say.
pub fn read_words(session: &mut Session, words: &[String]) -> Result<(), FlagError> {
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let name = word.strip_prefix("--").unwrap_or(word);
        let (name, value) = name.split_once('=').map_or((name, None), |(name, value)| (name, Some(value)));
        let flag = find(name)?;
        let value = match value {
            Some(value) => value,
            None if flag.is_switch() => "on",
            None => words.next().map_or("", String::as_str),
        };
        flag.read(session, value)?;
    }
    Ok(())
}

/// The scene as a word that is read back as the same scene: a file that is called like a built-in scene, or begins with
/// a dash, is named through its folder.
fn scene_word(scene: &SceneRef) -> String {
    let text = scene.text();
    match scene {
        SceneRef::File(_) if text.starts_with('-') || SceneRef::parse(&text) != *scene => {
            Path::new(".").join(text).to_string_lossy().into_owned()
        }
        SceneRef::File(_) | SceneRef::Builtin(_) => text,
    }
}

fn quoted(word: &str) -> String {
    // Safe in every POSIX shell, and easier to read bare; commas are not to shlex.
    let is_safe = |c: char| c.is_ascii_alphanumeric() || "_-./,:=+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_safe) {
        return word.to_owned();
    }
    let word = word.replace('\0', "");
    shlex::try_quote(&word).expect("a word without NUL can be quoted").into_owned()
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::render::View;
    use crate::scene::{Camera, UpAxis};

    #[test]
    fn names_are_unique_and_defaults_read_back() {
        let default = Session::default();
        for (i, flag) in flags().iter().enumerate() {
            assert!(flags()[..i].iter().all(|other| other.name != flag.name), "{} twice", flag.name);
            let mut session = default.clone();
            flag.read(&mut session, &flag.write(&default)).expect(flag.name);
            assert_eq!(session, default, "{}", flag.name);
        }
    }

    #[test]
    fn every_choice_can_be_chosen_and_is_written_back() {
        for flag in flags() {
            for choice in (flag.choices)() {
                let mut session = Session::default();
                let read = flag.read(&mut session, choice.name);
                // Of the instructions a processor has some only.
                if flag.name == "simd" && read.is_err() {
                    let reason = read.expect_err("an error").to_string();
                    assert!(
                        reason.contains("this processor has no") && reason.contains("scalar"),
                        "{reason}"
                    );
                    continue;
                }
                read.expect(choice.name);
                assert_eq!(flag.write(&session), choice.name, "--{}", flag.name);
            }
        }
    }

    #[test]
    fn a_refused_value_leaves_the_session_alone() {
        for flag in flags() {
            let mut session = Session::default();
            let error = flag.read(&mut session, "no such value").expect_err(flag.name);
            assert!(error.to_string().starts_with(&format!("--{} 'no such value': ", flag.name)));
            assert_eq!(session, Session::default(), "{}", flag.name);
        }
    }

    #[test]
    fn the_up_axis_goes_with_the_camera_in_either_order() {
        let mut session = Session::default();
        for (name, value) in [("camera", "1,2,3,0,0,0,40"), ("up", "z")] {
            find(name).expect(name).read(&mut session, value).expect(name);
        }
        assert_eq!(session.camera.map(|camera| camera.up), Some(UpAxis::Z));
    }

    #[test]
    fn the_command_names_only_what_differs() {
        let mut session = Session::default();
        assert_eq!(command_line(&session, "F.png"), "bvhscope render bunny --out F.png");
        session.view = View::NodesVisited;
        session.build_mut().bins = 8;
        session.overlay.leaves_only = true;
        assert_eq!(
            command_line(&session, "my picture.png"),
            "bvhscope render bunny --out 'my picture.png' --bins 8 --view nodes-visited --leaves-only"
        );
    }

    #[test]
    fn flag_words_are_read_back() {
        let mut session = Session { view: View::RayCost, ground: true, ..Session::default() };
        session.build_mut().leaf = 7;
        session.overlay.leaves_only = true;
        let mut read = Session::default();
        read_words(&mut read, &flag_words(&session)).expect("its own words");
        assert_eq!(read, session);
        for (words, message) in
            [("--nothing 3", "there is no flag --nothing"), ("--leaf", "--leaf '': "), ("x", "no flag --x")]
        {
            let words: Vec<_> = words.split(' ').map(str::to_owned).collect();
            let error = read_words(&mut Session::default(), &words).expect_err(message).to_string();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn odd_file_names_stay_files() {
        for (path, word) in [("-x.obj", "./-x.obj"), ("bunny", "./bunny"), ("it's.obj", "\"it's.obj\"")] {
            let mut session = Session::default();
            session.scene.reference = SceneRef::File(PathBuf::from(path));
            assert_eq!(command_line(&session, "F.png"), format!("bvhscope render {word} --out F.png"));
        }
    }

    #[test]
    fn a_camera_is_written_as_it_is_read() {
        let mut session = Session { camera: Some(Camera::default()), ..Session::default() };
        let text = find("camera").expect("a flag").write(&session);
        assert_eq!(text, "0,0,5,0,0,0,45");
        find("camera").expect("a flag").read(&mut session, "scene").expect("no camera");
        assert_eq!(session.camera, None);
    }
}

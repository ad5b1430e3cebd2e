//! The scene as its author wrote it: the serde model of the scene file.

/// A scene file's content.
#[derive(Clone, Debug)]
pub struct SceneDescription;

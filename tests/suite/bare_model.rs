//! A model without a scene is stood up, framed and lit.

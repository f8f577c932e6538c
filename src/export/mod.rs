//! Where pictures and figures leave the program: PNG with its session, EXR, CSV, JSON, Markdown. Every file is written
//! whole or not at all.

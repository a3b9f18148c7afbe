//! Small files built in code, the files of the data folder, and hostile ones.

mod builder;
mod clips;
mod files;
mod hostile;
mod influences;
mod mesh;
mod muscle_keys;
mod tree;

//! Reading and refusing; editing and mirroring.

mod edit;
mod mark;
mod read;
mod wrap;

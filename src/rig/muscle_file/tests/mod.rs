//! Reading and refusing; editing and mirroring.

mod edit;
mod read;
mod wrap;

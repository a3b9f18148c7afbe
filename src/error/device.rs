//! What can go wrong between the program and a graphics adapter.

/// A device that is missing, refuses, fails, or is asked for more than it has.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// The machine shows no adapter at all.
    #[error(
        "no graphics adapter found: install a Vulkan driver; one that needs no GPU comes with `apt-get install mesa-vulkan-drivers libvulkan1`"
    )]
    NoAdapter,
    /// There are adapters, but none that runs on the processor.
    #[error(
        "no software adapter among {}: install one with `apt-get install mesa-vulkan-drivers libvulkan1`, or choose another device",
        listed(had)
    )]
    NoSoftwareAdapter {
        /// Names of the adapters there are.
        had: Vec<String>,
    },
    /// There are adapters, but none of that name.
    #[error("no adapter's name contains {wanted:?}: choose among {}", listed(had))]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// Names of the adapters there are.
        had: Vec<String>,
    },
    /// The adapter exists but gives no device.
    #[error("adapter {adapter} gives no device: {reason}; choose another device or update its driver")]
    Refused {
        /// Name of the adapter.
        adapter: String,
        /// The driver's words.
        reason: String,
    },
    /// Submitted work did not finish in time.
    #[error(
        "adapter {adapter} did not finish its work within {seconds} s: ask for less per frame or choose another device"
    )]
    Timeout {
        /// Name of the adapter.
        adapter: String,
        /// How long was waited.
        seconds: u64,
    },
    /// The device went away.
    #[error("adapter {adapter} was lost: {reason}; run again, or choose another device")]
    Lost {
        /// Name of the adapter.
        adapter: String,
        /// The driver's words.
        reason: String,
    },
    /// The device's memory is used up.
    #[error("adapter {adapter} is out of memory: ask for a smaller picture or fewer vertices")]
    OutOfMemory {
        /// Name of the adapter.
        adapter: String,
    },
    /// A call broke the rules of the graphics interface: a fault of the program, not of its input.
    #[error("adapter {adapter} refused a call, please report this: {reason}")]
    Invalid {
        /// Name of the adapter.
        adapter: String,
        /// The violated rule.
        reason: String,
    },
    /// A buffer would be larger than the adapter allows.
    #[error("{what} needs a buffer of {needed} bytes, this adapter allows {had}")]
    BufferTooLarge {
        /// What the buffer would hold.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes the adapter allows.
        had: u64,
    },
    /// A picture's side is zero or longer than the adapter allows.
    #[error("a picture of {width} x {height} pixels is needed, this adapter allows sides of 1 to {had}")]
    PictureSize {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Longest side the adapter allows.
        had: u32,
    },
    /// A buffer cannot be read back as asked.
    #[error("cannot read back {what}: {problem}")]
    Readback {
        /// Label or description of what was to be read.
        what: String,
        /// Why not.
        problem: String,
    },
    /// A mesh, texture or vertex buffer cannot be drawn as given.
    #[error("cannot draw {what}: {problem}")]
    Undrawable {
        /// The element.
        what: String,
        /// What is wrong with it.
        problem: String,
    },
}

fn listed(names: &[String]) -> String {
    names.iter().map(|n| format!("{n:?}")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_adapter_names_the_packages_in_one_line() {
        let line = DeviceError::NoAdapter.to_string();
        assert!(line.contains("mesa-vulkan-drivers libvulkan1"));
        assert!(!line.contains('\n'));
    }

    #[test]
    fn a_wrong_name_lists_the_right_ones() {
        let had = vec!["llvmpipe".to_string(), "Radeon".to_string()];
        let line = DeviceError::NoSuchAdapter { wanted: "geforce".to_string(), had }.to_string();
        assert!(line.contains("geforce") && line.contains("\"llvmpipe\", \"Radeon\""), "{line}");
    }
}

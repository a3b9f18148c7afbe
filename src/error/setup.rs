//! What can keep kernels, buffers or instances from being set up on a device.

/// A set-up that the device or its caller's buffers do not allow. Nothing has been allocated when it is returned.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// More than a limit of the device.
    #[error("{what} needs {needed} and the device was opened with {limit} = {had}; {remedy}")]
    Limit {
        /// What asks for it.
        what: String,
        /// The amount that it needs.
        needed: u64,
        /// The limit's name in WebGPU.
        limit: &'static str,
        /// The amount that the device has.
        had: u64,
        /// What to do.
        remedy: &'static str,
    },
    /// A caller's output buffer that cannot take the vertices.
    #[error("the output buffer does not fit: {what}")]
    Output {
        /// What does not fit, with both numbers.
        what: String,
    },
    /// A binding that a kernel's table does not have, or that was not given.
    #[error("kernel `{kernel}` and its bindings disagree at `{binding}`")]
    Binding {
        /// The kernel.
        kernel: &'static str,
        /// The binding.
        binding: String,
    },
}

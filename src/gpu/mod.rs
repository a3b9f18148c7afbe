//! The GPU side: device, kernels, buffers by lifetime.

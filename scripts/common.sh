# Sourced by the other scripts: what they need of the machine.

need_rust() {
    if ! command -v cargo >/dev/null 2>&1; then
        echo "error: cargo is not on the path; install Rust 1.88 or later from https://rustup.rs" >&2
        exit 1
    fi
    if ! command -v cc >/dev/null 2>&1 && ! command -v gcc >/dev/null 2>&1 && ! command -v clang >/dev/null 2>&1; then
        echo "error: no C linker; run: apt-get install gcc libc6-dev" >&2
        exit 1
    fi
}

# Prints the driver file of Mesa's software Vulkan, or nothing.
software_driver() {
    local file
    for file in /usr/share/vulkan/icd.d/lvp_icd*.json /usr/local/share/vulkan/icd.d/lvp_icd*.json /etc/vulkan/icd.d/lvp_icd*.json; do
        if [ -f "$file" ]; then
            echo "$file"
            return
        fi
    done
}

# Installs Mesa's software Vulkan where that is allowed, else says what to run. Fails if there is none afterwards.
# $1: why it is needed.
install_software_driver() {
    local why="$1" packages="mesa-vulkan-drivers libvulkan1" as_root=""
    if command -v apt-get >/dev/null 2>&1; then
        if [ "$(id -u)" != 0 ]; then
            if command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
                as_root="sudo -n"
            else
                echo "error: $why, and this user may not install it; run: sudo apt-get install $packages" >&2
                return 1
            fi
        fi
        echo "$why: installing $packages" >&2
        local install="$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $packages"
        if ! $install >&2; then
            $as_root apt-get update -q >&2 && $install >&2 || true
        fi
    fi
    if [ -z "$(software_driver)" ]; then
        echo "error: $why; install Mesa's software Vulkan driver (Debian, Ubuntu: $packages)" >&2
        return 1
    fi
}

# A writable runtime folder and shader cache, kept with the build.
private_folders() {
    local target
    target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
    export XDG_RUNTIME_DIR="$target/runtime" MESA_SHADER_CACHE_DIR="$target/mesa-shader-cache"
    mkdir -p "$XDG_RUNTIME_DIR" "$MESA_SHADER_CACHE_DIR"
    chmod 700 "$XDG_RUNTIME_DIR"
}

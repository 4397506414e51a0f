//! Flags about textures.

use super::values::bytes;
use clap::Args;
use eosphor::job::memory_for_textures;

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Memory")]
pub(crate) struct TextureFlags {
    /// Memory limit for all textures together, such as 512M or 4G (K, M, G and T are powers of 1024) [default: half of the free
    /// memory]
    #[arg(long, value_name = "SIZE", value_parser = bytes, allow_hyphen_values = true)]
    texture_memory: Option<u64>,
}

impl TextureFlags {
    /// Bytes that textures may take; `None` where nobody says what is free.
    pub(crate) fn memory_bytes(&self) -> Option<u64> {
        self.texture_memory.or_else(memory_for_textures)
    }
}

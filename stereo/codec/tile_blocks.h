/// TileBlocks: packs the coded tiles of planes into LZ4 blocks that decompress independently. A
/// block takes as many whole tiles as fit into its datagram (LZ4_compress_destSize).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace farshade {

/// Largest content of a block. It limits the decoder's memory.
inline constexpr std::size_t kMaxOpened_bytes = 16384;

/// Most bytes that LZ4 needs for `bytes` bytes (LZ4_COMPRESSBOUND). Shows that every tile fits into a block.
constexpr std::size_t most_packed_bytes(std::size_t bytes) {
  return bytes + bytes / 255 + 16;
}

/// Reuses its buffers, so that it allocates only for the first blocks.
class TileBlocks {
 public:
  /// Removes all written tiles.
  void clear();

  /// Number of written tiles that are not packed yet.
  [[nodiscard]] std::uint32_t ready() const { return static_cast<std::uint32_t>(ends_.size()); }
  [[nodiscard]] bool has_room_for(std::size_t tile_bytes) const {
    return written_.size() + tile_bytes <= kMaxOpened_bytes;
  }
  /// `write(bytes)` appends one tile. The caller has checked that there is room.
  template <class Write>
  void add(Write&& write) {
    write(written_);
    ends_.push_back(written_.size());
  }

  struct Packed {
    std::uint32_t tiles = 0;
    std::size_t block_bytes = 0;
  };
  /// Packs as many written tiles as possible, at least one, into `block` and removes them. `block` must have
  /// room for every single tile.
  Packed pack(std::span<std::byte> block);

 private:
  [[nodiscard]] std::size_t end_of(std::uint32_t tiles) const { return tiles == 0 ? 0 : ends_[tiles - 1]; }
  [[nodiscard]] Packed compress(std::span<std::byte> block) const;

  std::vector<std::byte> written_;
  std::vector<std::size_t> ends_;  ///< end of each tile in written_
};

using OpenedBlock = std::array<std::byte, kMaxOpened_bytes>;

/// Decompresses `block` into `opened`. Returns nothing if it is not an LZ4 block or has more content.
[[nodiscard]] std::optional<std::span<const std::byte>> open_block(std::span<const std::byte> block,
                                                                   OpenedBlock& opened);

/// Compresses `bytes` to one LZ4 block at the start of `block`. Returns its length; 0 if it does not fit, or
/// if LZ4 cannot have so much content (2 GB).
[[nodiscard]] std::size_t pack_block(std::span<const std::byte> bytes, std::span<std::byte> block);
/// Decompresses `block` into all of `opened`. False if it is not an LZ4 block, or has less or more content.
[[nodiscard]] bool open_whole_block(std::span<const std::byte> block, std::span<std::byte> opened);

}  // namespace farshade

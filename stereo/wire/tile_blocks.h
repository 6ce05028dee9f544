/// TileBlocks: tiles, as bytes one after the other, packed into LZ4 blocks that each open alone. A block
/// takes as many whole tiles as its datagram holds (LZ4_compress_destSize). Masks and planes travel so.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace farshade {

/// What a block opens to at most; bounds the decoder's memory.
inline constexpr std::size_t kMaxOpened_bytes = 16384;

/// What LZ4 makes of `bytes` bytes at most (LZ4_COMPRESSBOUND), for claims that any tile fits a block.
constexpr std::size_t most_packed_bytes(std::size_t bytes) {
  return bytes + bytes / 255 + 16;
}

/// Keeps its buffers, so that packing allocates nothing once warm.
class TileBlocks {
 public:
  /// No tile lies ready.
  void clear();

  /// Tiles that lie ready to be packed.
  [[nodiscard]] std::uint32_t ready() const { return static_cast<std::uint32_t>(ends_.size()); }
  [[nodiscard]] bool has_room_for(std::size_t tile_bytes) const {
    return written_.size() + tile_bytes <= kMaxOpened_bytes;
  }
  /// `write(bytes)` appends one tile, for which there is room.
  template <class Write>
  void add(Write&& write) {
    write(written_);
    ends_.push_back(written_.size());
  }

  struct Packed {
    std::uint32_t tiles = 0;
    std::size_t block_bytes = 0;
  };
  /// Packs the first of the ready tiles, at least one, into `block`, which holds any one, and takes them
  /// away.
  Packed pack(std::span<std::byte> block);

 private:
  [[nodiscard]] std::size_t end_of(std::uint32_t tiles) const { return tiles == 0 ? 0 : ends_[tiles - 1]; }
  [[nodiscard]] Packed compress(std::span<std::byte> block) const;

  std::vector<std::byte> written_;
  std::vector<std::size_t> ends_;  ///< where each tile ends in written_
};

using OpenedBlock = std::array<std::byte, kMaxOpened_bytes>;

/// What `block` opens to, in `opened`; nothing if it is no LZ4 block, or holds more.
[[nodiscard]] std::optional<std::span<const std::byte>> open_block(std::span<const std::byte> block,
                                                                   OpenedBlock& opened);

/// Of the library that packs them, for people.
[[nodiscard]] std::string lz4_version();

}  // namespace farshade

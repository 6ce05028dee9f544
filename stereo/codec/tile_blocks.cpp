#include "stereo/codec/tile_blocks.h"

#include <lz4.h>

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {
namespace {

const char* chars(const std::byte* bytes) {
  return reinterpret_cast<const char*>(bytes);
}
char* chars(std::byte* bytes) {
  return reinterpret_cast<char*>(bytes);
}

}  // namespace

void TileBlocks::clear() {
  written_.clear();
  ends_.clear();
}

TileBlocks::Packed TileBlocks::pack(std::span<std::byte> block) {
  check(!ends_.empty(), "there is a tile to pack");
  const Packed packed = compress(block);
  const std::size_t bytes = end_of(packed.tiles);
  written_.erase(written_.begin(), written_.begin() + static_cast<std::ptrdiff_t>(bytes));
  ends_.erase(ends_.begin(), ends_.begin() + packed.tiles);
  for (std::size_t& end : ends_) end -= bytes;
  return packed;
}

/// LZ4 returns how many bytes fit. The tile in which they end is left for the next block. The complete tiles
/// before it are compressed again. If that needs more bytes, which is rare, one more tile is left for the
/// next block.
TileBlocks::Packed TileBlocks::compress(std::span<std::byte> block) const {
  int taken = static_cast<int>(written_.size());
  const int filled = LZ4_compress_destSize(chars(written_.data()), chars(block.data()), &taken,
                                           static_cast<int>(block.size()));
  const auto end = std::upper_bound(ends_.begin(), ends_.end(), static_cast<std::size_t>(taken));
  auto tiles = static_cast<std::uint32_t>(end - ends_.begin());
  if (tiles > 0 && end_of(tiles) == static_cast<std::size_t>(taken))
    return {tiles, static_cast<std::size_t>(filled)};
  for (tiles = std::max(tiles, 1u); tiles > 0; --tiles) {
    const int size = LZ4_compress_default(chars(written_.data()), chars(block.data()),
                                          static_cast<int>(end_of(tiles)), static_cast<int>(block.size()));
    if (size > 0) return {tiles, static_cast<std::size_t>(size)};
  }
  check(false, "one tile fits into a block");
  return {};
}

std::optional<std::span<const std::byte>> open_block(std::span<const std::byte> block, OpenedBlock& opened) {
  const int size = LZ4_decompress_safe(chars(block.data()), chars(opened.data()),
                                       static_cast<int>(block.size()), static_cast<int>(opened.size()));
  if (size < 0) return std::nullopt;
  return std::span(opened).first(static_cast<std::size_t>(size));
}

std::size_t pack_block(std::span<const std::byte> bytes, std::span<std::byte> block) {
  if (bytes.size() > LZ4_MAX_INPUT_SIZE) return 0;
  return static_cast<std::size_t>(LZ4_compress_default(
      chars(bytes.data()), chars(block.data()), static_cast<int>(bytes.size()), narrow<int>(block.size())));
}

bool open_whole_block(std::span<const std::byte> block, std::span<std::byte> opened) {
  if (opened.size() > LZ4_MAX_INPUT_SIZE) return false;
  const int size = LZ4_decompress_safe(chars(block.data()), chars(opened.data()), narrow<int>(block.size()),
                                       static_cast<int>(opened.size()));
  return size >= 0 && static_cast<std::size_t>(size) == opened.size();
}

}  // namespace farshade

#include "stereo/answers/frame_packer.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"

namespace farshade {

namespace {

/// The distance of a slice's tiles from the middle row of its view, in rows of tiles.
std::uint32_t rows_from_middle(const Slice& slice) {
  const TileGrid grid{slice.size};
  const std::uint32_t first = slice.first_tile / grid.columns(),
                      last = (slice.first_tile + slice.tile_count - 1) / grid.columns(),
                      middle = grid.rows() / 2;
  return middle < first ? first - middle : middle > last ? middle - last : 0;
}

}  // namespace

/// Sorts the slices from `first` on; stable, so that both eyes' slices stay in turn.
void FramePacker::sort_from(std::size_t first) {
  std::vector<std::size_t> order(from_middle_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return from_middle_[i]; });
  std::vector<std::vector<std::byte>> sorted;
  for (const std::size_t i : order) sorted.push_back(std::move(datagrams_[first + i]));
  std::ranges::move(sorted, datagrams_.begin() + static_cast<std::ptrdiff_t>(first));
}

void FramePacker::begin(std::size_t most_bytes, ProtocolVersion version) {
  most_bytes_ = most_bytes;
  version_ = version;
  datagrams_.clear();
  payload_bytes_ = 0;
  packing_ = {};
}

void FramePacker::add(const ServerMessage& message) {
  std::vector<std::byte>& datagram = next_datagram();
  encode(message, datagram, version_);
  payload_bytes_ += datagram.size();
}

void FramePacker::add(const ShadowFrame& frame, const RequestedBlocks& requested,
                      const PerEye<std::span<const std::uint8_t>>& sent) {
  const Stopwatch packing;
  const std::size_t first = datagrams_.size();
  from_middle_.clear();
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    packers_[eye].start(frame, side, requested.tiles[eye], sent[eye], most_bytes_);
  }
  for (bool more = true; more;) {
    more = false;
    for (SlicePacker& packer : packers_)
      if (const std::optional<Slice> slice = packer.next()) {
        add(ServerMessage(*slice));
        from_middle_.push_back(rows_from_middle(*slice));
        more = true;
      }
  }
  sort_from(first);
  packing_ += packing.elapsed();
}

void FramePacker::add(FrameId frame, const GBufferPlanes& gbuffer) {
  const Stopwatch packing;
  for (const PlaneKind kind : kGBufferKinds)
    for (const Side side : kSides) {
      plane_packer_.start(frame, side, kind, planes_of(gbuffer, kind)[index_of(side)], most_bytes_);
      while (const std::optional<PlaneSlice> slice = plane_packer_.next()) add(ServerMessage(*slice));
    }
  packing_ += packing.elapsed();
}

void FramePacker::add(FrameId frame, FrameId after, const VideoUnitParts& parts) {
  const Stopwatch packing;
  const auto count = narrow<std::uint32_t>(parts.size());
  check(count >= 1 && count <= kMostVideoParts, "a coded picture has so many parts");
  for (std::uint32_t part = 0; part < count; ++part) {
    // Zeros may follow a NAL unit (H.264, B.1: trailing_zero_8bits).
    std::array<std::byte, kVideoPart_bytes> padded{};
    std::ranges::copy(parts[part], padded.begin());
    const bool is_last = part + 1 == count;
    add(ServerMessage(VideoPart{.frame = frame,
                                .after = after,
                                .part = part,
                                .parts = count,
                                .bytes = is_last ? parts[part] : std::span<const std::byte>(padded)}));
  }
  packing_ += packing.elapsed();
}

std::vector<std::vector<std::byte>> FramePacker::finish(FrameReport report) {
  report.slices = narrow<std::uint32_t>(datagrams_.size());
  report.payload_bytes = narrow<std::uint32_t>(payload_bytes_);
  report.pack += packing_;
  encode(report, next_datagram(), version_);
  return std::exchange(datagrams_, {});
}

std::vector<std::byte>& FramePacker::next_datagram() {
  datagrams_.emplace_back().reserve(kMaxMessage_bytes);
  return datagrams_.back();
}

}  // namespace farshade

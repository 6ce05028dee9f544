/// Assembler: slices and parts back into what was asked for, in whatever order, number and state they come. A
/// slice that never comes leaves its tiles unknown in that frame and changes nothing else; one that does not
/// fit what was asked for changes nothing but a counter. Memory is so many frames, used again.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/frame/shadow_frame.h"
#include "stereo/wire/messages.h"
#include "stereo/wire/plane_codec.h"
#include "stereo/wire/slice.h"

namespace farshade {

/// A G-buffer's planes, tile by tile; words of tiles that are not known are 0.
struct ReceivedGBuffer {
  GBufferPlanes planes;
  std::array<PerEye<KnownTiles>, kGBufferKinds.size()> known_tiles;
  std::uint32_t tiles_known = 0, tiles = 0;  ///< of all planes of both eyes
};

/// A coded picture's parts.
struct ReceivedVideo {
  FrameId after;                ///< as the parts say
  std::vector<std::byte> unit;  ///< the parts in their places
  std::vector<bool> known;
  std::uint32_t parts_known = 0;

  [[nodiscard]] bool complete() const { return !known.empty() && parts_known == known.size(); }
};

/// What has come of one request so far. Bits of tiles that are not known are 0 and mean nothing. Of masks,
/// G-buffer and video those are there that were wanted.
struct ReceivedFrame {
  FrameRequest request;
  std::uint32_t light_set_revision = 0;
  PerEye<EyeMask> masks;
  PerEye<KnownTiles> known_tiles;
  PerEye<std::uint32_t> tiles_known{};  ///< planes counted one by one
  ReceivedGBuffer gbuffer;
  ReceivedVideo video;
  std::optional<FrameReport> report;

  [[nodiscard]] bool complete(Side side) const {
    const EyeMask& mask = masks[index_of(side)];
    return tiles_known[index_of(side)] == known_tiles[index_of(side)].size() * mask.layout().planes();
  }
  [[nodiscard]] bool complete() const;
  [[nodiscard]] bool anything_known() const { return pieces_known() > 0; }
  /// Tiles and parts.
  [[nodiscard]] std::uint32_t pieces_known() const {
    return tiles_known[0] + tiles_known[1] + gbuffer.tiles_known + video.parts_known;
  }
};

struct AssemblerCounters {
  std::uint64_t slices = 0;      ///< and parts taken, duplicates not among them
  std::uint64_t duplicates = 0;  ///< told nothing new
  std::uint64_t unexpected = 0;  ///< of a frame never asked for, or forgotten
  std::uint64_t other_light_set = 0;
  RefusalCounts refused{};  ///< of a mask of another shape, or faulty inside
  friend bool operator==(const AssemblerCounters&, const AssemblerCounters&) = default;
};

class Assembler {
 public:
  /// Frames of which something is known that no newer request without an answer drives out: through a silence
  /// of the network the last masks stay in hand.
  static constexpr std::size_t kKept = 4;

  /// Remembers `frames` requests, more than kKept: those kept, and the newest.
  explicit Assembler(std::size_t frames = 8);

  /// From now on takes slices of `request`, whose masks shall lie as `layout` says, of the light set
  /// `revision`. `request.frame` is newer than every frame expected before. When there is no room, the
  /// oldest request that is not kept is forgotten: pointers to its frame then show the new one.
  void expect(const FrameRequest& request, MaskLayout layout, std::uint32_t revision);

  /// The frame that now knows more; null if nothing changed.
  const ReceivedFrame* accept(const Slice& slice);
  const ReceivedFrame* accept(const PlaneSlice& slice);
  const ReceivedFrame* accept(const VideoPart& part);
  /// The frame that now has its report; null if it is none of ours.
  const ReceivedFrame* accept(const FrameReport& report);

  /// Null if not remembered. Frames stay where they are until they are forgotten.
  [[nodiscard]] const ReceivedFrame* find(FrameId frame) const;
  /// The newest frame of which anything is known; null if there is none.
  [[nodiscard]] const ReceivedFrame* newest_known() const;

  /// Forgets every request, not the counters: for another server or scene.
  void clear();

  [[nodiscard]] const AssemblerCounters& counters() const { return counters_; }

 private:
  [[nodiscard]] ReceivedFrame* slot_of(FrameId frame);
  [[nodiscard]] ReceivedFrame* wanted(FrameId frame);
  const ReceivedFrame* count(ReceivedFrame& frame, const Decoded<std::uint32_t>& news, std::uint32_t& known);
  [[nodiscard]] bool is_kept(const ReceivedFrame& frame) const;
  [[nodiscard]] ReceivedFrame& room();
  [[nodiscard]] std::span<const ReceivedFrame> remembered() const { return std::span(slots_).first(used_); }

  std::vector<ReceivedFrame> slots_;
  std::size_t used_ = 0;  ///< slots that hold a request
  std::optional<FrameId> newest_;
  AssemblerCounters counters_;
};

}  // namespace farshade

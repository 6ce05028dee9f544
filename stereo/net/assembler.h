/// Assembler: slices back into masks, in whatever order, number and state they come. A slice that never comes
/// leaves its tiles unknown in that frame and changes nothing else; a slice that does not fit what was asked
/// for changes nothing but a counter. Memory is so many frames, used again.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/frame/shadow_frame.h"
#include "stereo/wire/messages.h"
#include "stereo/wire/slice.h"

namespace farshade {

/// What has come of one request so far. Bits of tiles that are not known are 0 and mean nothing.
struct ReceivedFrame {
  TraceRequest request;
  std::uint32_t light_set_revision = 0;
  PerEye<EyeMask> masks;
  PerEye<KnownTiles> known_tiles;
  PerEye<std::uint32_t> tiles_known{};  ///< planes counted one by one
  std::optional<FrameReport> report;

  [[nodiscard]] bool complete(Side side) const {
    const EyeMask& mask = masks[index_of(side)];
    return tiles_known[index_of(side)] == known_tiles[index_of(side)].size() * mask.layout().planes();
  }
  [[nodiscard]] bool complete() const { return complete(Side::Left) && complete(Side::Right); }
  [[nodiscard]] bool anything_known() const { return tiles_known[0] + tiles_known[1] > 0; }
};

struct AssemblerCounters {
  std::uint64_t slices = 0;      ///< taken, duplicates not among them
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
  void expect(const TraceRequest& request, MaskLayout layout, std::uint32_t revision);

  /// The frame that now knows more; null if nothing changed.
  const ReceivedFrame* accept(const Slice& slice);
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
  [[nodiscard]] bool is_kept(const ReceivedFrame& frame) const;
  [[nodiscard]] ReceivedFrame& room();
  [[nodiscard]] std::span<const ReceivedFrame> remembered() const { return std::span(slots_).first(used_); }

  std::vector<ReceivedFrame> slots_;
  std::size_t used_ = 0;  ///< slots that hold a request
  std::optional<FrameId> newest_;
  AssemblerCounters counters_;
};

}  // namespace farshade

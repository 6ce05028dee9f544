/// Assembler: the client's memory of its requests, a ring of records. It fills each record with the pieces of
/// its answer, in whatever order they come. A piece that never comes leaves its tiles unknown in that record
/// and changes nothing else. A piece that does not fit its request only increments a counter. Everything else
/// that is kept for each request, such as the depth of its views, lies at the place with the record's slot
/// number, so that one eviction rule holds for all of it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/codec/plane_codec.h"
#include "stereo/codec/slice.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/traced_mask.h"
#include "stereo/messages/messages.h"

namespace farshade {

/// The planes of a G-buffer. Words of unknown tiles are 0.
struct ReceivedGBuffer {
  GBufferPlanes planes;
  std::array<PerEye<ReceivedTiles>, kGBufferKinds.size()> received_tiles;
  std::uint32_t tiles_known = 0, tiles = 0;  ///< counted over all planes of both eyes
};

/// The parts of a coded picture, or of a block of masks. Zeros replace parts that have not come. Between NAL
/// units they mean nothing, so a decoder reads the other parts (stereo/answers/video_parts.h).
struct ReceivedVideo {
  FrameId after;                ///< from the parts
  std::vector<std::byte> unit;  ///< the parts in order; empty until the first has come
  std::vector<bool> known;
  std::uint32_t parts_known = 0;

  [[nodiscard]] bool complete() const { return !known.empty() && parts_known == known.size(); }
};

/// When and by whom a request was made.
struct RequestOrigin {
  Time requested_at;          ///< the display time of the frame that made it
  Time sent;                  ///< on the client's clock
  std::uint64_t session = 0;  ///< counts the sessions of this client
};

/// All that the client knows about one request: the request, when it was made, and what has come of its
/// answer. Bits of tiles that are not known are 0 and mean nothing. The record holds masks, G-buffer or video
/// as the request asks for.
struct RequestRecord {
  std::size_t slot = 0;  ///< the record's place in the ring
  FrameRequest request;
  RequestOrigin origin;
  std::optional<Time> first_piece, report_arrived;  ///< on the client's clock
  LightSetRevision light_set_revision{};
  PerEye<EyeMask> masks;
  PerEye<ReceivedTiles> received_tiles;
  PerEye<std::uint32_t> tiles_known{};      ///< each plane of a tile counts; known: its requested blocks are
  PerEye<std::uint32_t> tiles_requested{};  ///< tiles with a requested block; others are never known
  ReceivedGBuffer gbuffer;
  ReceivedVideo video;
  std::optional<FrameReport> report;

  [[nodiscard]] bool complete(Side side) const {
    const std::size_t eye = index_of(side);
    return tiles_known[eye] == tiles_requested[eye] * masks[eye].layout().planes();
  }
  [[nodiscard]] bool complete() const;
  /// Parts of a block of masks are of no use before all have come.
  [[nodiscard]] bool anything_known() const {
    const std::uint32_t useless = request.answer.coding == Coding::Lz4 ? video.parts_known : 0;
    return pieces_known() > useless;
  }
  /// Number of received tiles and parts.
  [[nodiscard]] std::uint32_t pieces_known() const {
    return tiles_known[0] + tiles_known[1] + gbuffer.tiles_known + video.parts_known;
  }
};

/// The masks of an answer. References to the record are kept.
[[nodiscard]] TracedMask mask_of(const RequestRecord& record);

struct AssemblerCounters {
  std::uint64_t slices = 0;      ///< accepted slices and parts, without duplicates
  std::uint64_t duplicates = 0;  ///< slices and parts with nothing new
  std::uint64_t unexpected = 0;  ///< of a frame without a record
  std::uint64_t other_light_set = 0;
  RefusalCounts refused{};  ///< slices that do not fit the request, or are damaged
  AssemblerCounters& operator+=(const AssemblerCounters& other);
  friend bool operator==(const AssemblerCounters&, const AssemblerCounters&) = default;
};

class Assembler {
 public:
  /// The eviction rule: a new request takes the slot of the oldest record, but never of the newest kKept
  /// records with any piece. So the last masks survive when the network is silent and requests go on.
  static constexpr std::size_t kKept = 4;

  /// A ring of `frames` records, more than kKept.
  explicit Assembler(std::size_t frames = 8);

  /// Makes the record of `request`, whose answer has masks of this layout and light set. `request.frame` is
  /// newer than every frame expected before. `reprojected` are the bits of the blocks that the request does
  /// not ask for; null: it asks for all. Pointers to the record that is evicted then refer to the new one.
  void expect(const FrameRequest& request, MaskLayout layout, LightSetRevision revision,
              const RequestOrigin& origin = {}, const PerEye<EyeMask>* reprojected = nullptr);

  /// Takes a piece that came at `arrived`. Returns the record that has changed; null if nothing has.
  const RequestRecord* accept(const Slice& slice, Time arrived = {});
  const RequestRecord* accept(const PlaneSlice& slice, Time arrived = {});
  const RequestRecord* accept(const VideoPart& part, Time arrived = {});
  /// Takes the report of an answer. Returns its record; null if there is no such request.
  const RequestRecord* accept(const FrameReport& report, Time arrived = {});

  /// The slot of the next request's record, if no piece comes before.
  [[nodiscard]] std::size_t next_slot() const;

  /// All records, in no particular order.
  [[nodiscard]] std::span<const RequestRecord> records() const { return std::span(slots_).first(used_); }

  /// The record of `frame`, or null. A record stays at its address until it is evicted.
  [[nodiscard]] const RequestRecord* find(FrameId frame) const;
  /// The newest record with any piece, or null.
  [[nodiscard]] const RequestRecord* newest_known() const;

  [[nodiscard]] const AssemblerCounters& counters() const { return counters_; }

 private:
  [[nodiscard]] RequestRecord* slot_of(FrameId frame);
  [[nodiscard]] RequestRecord* find_or_count(FrameId frame);
  const RequestRecord* count(RequestRecord& record, const Decoded<std::uint32_t>& news, std::uint32_t& known,
                             Time arrived);
  [[nodiscard]] bool is_kept(const RequestRecord& frame) const;

  std::vector<RequestRecord> slots_;
  std::size_t used_ = 0;  ///< slots with a record
  std::optional<FrameId> newest_;
  AssemblerCounters counters_;
};

}  // namespace farshade

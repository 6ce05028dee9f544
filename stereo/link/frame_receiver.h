/// FrameReceiver: the client's side of a session, whoever carries its messages. Requests go out through it,
/// and the server's messages come in. It has no socket, no keys and no clock, so that a capture file fills it
/// as the network does. It owns the records of all requests (stereo/answers/assembler.h).
#pragma once

#include <vector>

#include "stereo/answers/assembler.h"
#include "stereo/base/expected.h"
#include "stereo/frame/cube_mask.h"

namespace farshade {

class FrameReceiver {
 public:
  /// Keeps `frames` records, and kCubeMaskSlots of the cube mask. The masks of all answers have this layout.
  FrameReceiver(std::size_t frames, MaskLayout layout)
      : assembler_(frames), cube_mask_(kCubeMaskSlots), layout_(layout) {}

  /// A session begins: its server knows no light changes and answers no earlier request.
  void begin(const Welcome& welcome);

  /// Makes the record of a request that the frame of display time `requested_at` makes and that is sent at
  /// `now`. Returns the request to send: with the light changes that the server may not have yet.
  /// `reprojected`: see RequestParts (server_connection.h).
  [[nodiscard]] FrameRequest ask(const FrameRequest& request, Time requested_at, Time now,
                                 const PerEye<EyeMask>* reprojected = nullptr);

  /// Takes a message of the server that came at `arrived`.
  void take(const FrameReport& report, Time arrived);
  /// Slice, PlaneSlice or VideoPart.
  void take(const auto& piece, Time arrived) {
    acknowledge(assembler_of(piece.frame).accept(piece, arrived));
  }

  /// The record of a request; null if there is none. It stays valid until its slot is used again.
  [[nodiscard]] const RequestRecord* find(FrameId frame) const;
  /// The newest record with any piece; null if there is none.
  [[nodiscard]] const RequestRecord* newest_known() const { return assembler_.newest_known(); }
  /// The records with any piece that were asked for up to the display time `until`, newest first.
  [[nodiscard]] std::vector<const RequestRecord*> received(Time until) const;
  /// The best record of each pair of the cube mask that was asked for up to the display time `until`: the
  /// newest whole one, else the newest that is as complete as it will be.
  [[nodiscard]] std::vector<const RequestRecord*> cube_mask(Time until) const;
  /// All records of the cube mask, in no particular order.
  [[nodiscard]] std::span<const RequestRecord> cube_mask_records() const { return cube_mask_.records(); }

  /// The slot of the next request's record.
  [[nodiscard]] std::size_t next_slot() const { return assembler_.next_slot(); }

  /// All pieces and the report have come.
  [[nodiscard]] bool is_whole(FrameId frame) const;
  /// The record is as complete as it will be: all pieces have come, or the report, which is sent last, or a
  /// piece of a newer request.
  [[nodiscard]] bool is_settled(const RequestRecord& record) const;
  /// The request was made in the present session.
  [[nodiscard]] bool may_come(FrameId frame) const;

  /// The number of pixels of an eye that the server traces at most.
  [[nodiscard]] std::uint32_t most_pixels() const { return most_pixels_; }
  /// The server's exposure; empty before the first session.
  [[nodiscard]] std::optional<Exposure> exposure() const { return exposure_; }
  /// The size of views that the server asks for, because of what the path carries.
  [[nodiscard]] ViewScale view_scale() const { return view_scale_; }
  /// The server gives answers of this kind.
  [[nodiscard]] bool offers(Answer answer) const { return (answers_ & set_of(answer)) != 0; }
  [[nodiscard]] AssemblerCounters counters() const;

 private:
  void acknowledge(const RequestRecord* changed);
  [[nodiscard]] Assembler& assembler_of(FrameId frame);

  Assembler assembler_, cube_mask_;
  MaskLayout layout_;
  std::uint64_t session_ = 0;                       ///< counts sessions
  LightSetRevision acknowledged_ = kFirstLightSet;  ///< the newest light set that the server surely has
  std::optional<FrameId> newest_report_;
  std::uint32_t most_pixels_ = Welcome{}.most_pixels;
  AnswerSet answers_ = 0;
  std::optional<Exposure> exposure_;
  ViewScale view_scale_{};
};

}  // namespace farshade

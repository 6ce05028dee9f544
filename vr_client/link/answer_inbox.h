/// AnswerInbox: what was asked for and what has come of it, whoever carried it: requests in, opened messages
/// in, masks and pictures out. Knows no sockets, no sessions' keys and no clock, so that a session on file
/// fills it as the wire does.
#pragma once

#include <vector>

#include "stereo/net/assembler.h"

namespace farshade {

class AnswerInbox {
 public:
  /// Remembers `frames` requests for masks that lie as `layout` says, as Assembler does.
  AnswerInbox(std::size_t frames, MaskLayout layout) : assembler_(frames), layout_(layout) {}

  /// A session has begun: the other side knows of no light change, and answers nothing asked before.
  void begin(const Welcome& welcome);

  /// Expects masks of `request`, asked for by the frame of the display time `asked_at`, sent at `now`.
  /// Returns the request as it goes out: of its light set, what the server is not known to have.
  [[nodiscard]] FrameRequest ask(const FrameRequest& request, Time asked_at, Time now);

  /// Takes what the server said, and when that reached us.
  void take(const Slice& slice, Time arrived);
  void take(const PlaneSlice& slice, Time arrived);
  void take(const VideoPart& part, Time arrived);
  void take(const FrameReport& report, Time arrived);

  /// Frames of which something is known and that were asked for up to the display time `until`, newest first.
  [[nodiscard]] std::vector<const ReceivedFrame*> received(Time until) const;

  /// When a frame that is still remembered was asked for, as a display time.
  [[nodiscard]] std::optional<Time> asked_at(FrameId frame) const;

  /// Null if nothing of it is in hand.
  [[nodiscard]] const ReceivedFrame* find(FrameId frame) const { return assembler_.find(frame); }
  [[nodiscard]] const ReceivedFrame* newest_known() const { return assembler_.newest_known(); }

  /// All of it and its report have come.
  [[nodiscard]] bool is_whole(FrameId frame) const;
  /// It was asked for in the session at hand.
  [[nodiscard]] bool may_come(FrameId frame) const;

  /// When a request went out and its answer came, on the clock that `ask` and `take` were told.
  struct Exchange {
    FrameId frame;
    Time sent;
    std::optional<Time> first;  ///< of its slices
    std::optional<Time> last;   ///< its report, sent behind all slices
  };
  /// Null if the request is forgotten. Good until the next request.
  [[nodiscard]] const Exchange* exchange(FrameId frame) const;

  /// Of an eye, that the server traces; as it said when it welcomed us.
  [[nodiscard]] std::uint32_t most_pixels() const { return most_pixels_; }
  /// The size of views that the server asks for, because of what the path carries.
  [[nodiscard]] ViewScale view_scale() const { return view_scale_; }
  [[nodiscard]] const AssemblerCounters& counters() const { return assembler_.counters(); }

 private:
  struct Asked {
    Exchange exchange;
    Time at;  ///< display time of the frame that asked
    std::uint64_t session;
  };

  void note(const ReceivedFrame* frame, Time arrived);

  Assembler assembler_;
  MaskLayout layout_;
  std::vector<Asked> asked_;                     ///< oldest first; those that the assembler remembers
  std::uint64_t session_ = 0;                    ///< counts sessions
  std::uint32_t acknowledged_ = kFirstLightSet;  ///< the light set that the server surely has
  std::optional<FrameId> newest_report_;
  std::uint32_t most_pixels_ = Welcome{}.most_pixels;
  ViewScale view_scale_{};
};

}  // namespace farshade

/// WaitingRequests: what one client has requested and was not answered yet. Only the newest request waits;
/// requests for the cube mask wait apart, so that they and the others do not replace each other. A request
/// may announce messages, its parts; it is complete when they have come. Memory is bounded.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>

#include "rt_server/sessions/job.h"
#include "stereo/frame/cube_mask.h"
#include "stereo/messages/messages.h"

namespace farshade {

/// Maximum total size of the messages that follow one request. The server drops messages beyond it, and
/// those with more tiles than the requested views have.
inline constexpr std::size_t kMostParts_bytes = std::size_t{16} << 20;

/// What an opened datagram of the client contained.
enum class ReceivedMessage : std::uint8_t {
  NewRequest,  ///< a request newer than all before
  Superseded,  ///< the same, and it replaced one that was waiting
  Outdated,    ///< a request that is not newer than all before
  TooLarge,    ///< a request for more pixels than the server allows
  Unanswered,  ///< a request for an answer that the server does not offer
  Part,        ///< a message that the waiting request announced
  Stray,       ///< one of another request, or more than it announced
  OverMemory,  ///< one for which its key has no memory left
  Left,        ///< the client's last message: its session is over
};

class WaitingRequests {
 public:
  /// A request for the cube mask is taken before another one only if so many others have overtaken it.
  static constexpr std::uint32_t kMostOvertaking = 3;

  /// Accepts requests for views of at most `most_pixels` and for `answers`.
  WaitingRequests(std::uint32_t most_pixels, AnswerSet answers)
      : most_pixels_(most_pixels), answers_(answers) {}
  /// From now on accepts only requests for `answers`.
  void offer(AnswerSet answers) { answers_ = answers; }

  /// Stores a request with all light changes so far, or says why not.
  [[nodiscard]] ReceivedMessage receive(const FrameRequest& request, Time now);
  /// Stores `message`, from which the slice was decoded, if it is a part of the waiting request and takes at
  /// most `room` bytes of memory.
  [[nodiscard]] ReceivedMessage receive(const PlaneSlice& slice, std::span<const std::byte> message, Time now,
                                        std::size_t room);
  [[nodiscard]] ReceivedMessage receive(const AskSlice& slice, std::span<const std::byte> message, Time now,
                                        std::size_t room);

  /// Whether a request has been accepted so far.
  [[nodiscard]] bool any() const;
  /// The kind of answer that the last accepted request wants; none before the first.
  [[nodiscard]] std::optional<Answer> requested_answer() const { return requested_answer_; }
  /// Mean time between two requests.
  [[nodiscard]] Duration interval() const { return interval_; }
  /// Memory of the parts that wait.
  [[nodiscard]] std::size_t bytes() const {
    return waiting_ ? parts_bytes_ + kMessage_bytes * waiting_->parts.size() : 0;
  }

  /// From when on take() may be called: the clock's zero if a request is complete, else when its missing
  /// parts are no longer waited for; nothing if no request waits.
  [[nodiscard]] std::optional<Time> ready_at() const;
  /// Removes the request that is next. Only when ready_at() has come. The job has no session yet.
  [[nodiscard]] Job take();

 private:
  [[nodiscard]] std::optional<ReceivedMessage> refuse(const FrameRequest& request) const;
  [[nodiscard]] std::optional<Job>& waiting_for(const FrameRequest& request);
  [[nodiscard]] std::optional<std::size_t> oldest_cube_mask() const;
  [[nodiscard]] bool is_complete() const;
  template <class TileSlice>
  ReceivedMessage receive_part(Answer of, const TileSlice& slice, std::span<const std::byte> message,
                               Time now, std::size_t room);
  void update_interval(const FrameRequest& request, Time now);

  std::uint32_t most_pixels_;
  AnswerSet answers_;
  std::optional<FrameId> newest_{};
  std::optional<Answer> requested_answer_{};
  Time newest_display_{}, newest_arrived_{};  ///< display time and arrival of the newest request
  Duration interval_{};
  std::optional<Job> waiting_{};
  /// One of each pair.
  std::array<std::optional<Job>, kCubeMaskPairs> waiting_cube_mask_{};
  std::array<std::optional<FrameId>, kCubeMaskPairs> newest_cube_mask_{};
  std::uint32_t overtaken_ = 0;  ///< other requests that were taken while the cube mask's waited
  std::size_t parts_bytes_ = 0;  ///< total size of waiting_->parts
  std::size_t tiles_left_ = 0;   ///< that further parts may have: the worker decodes each
  Time part_arrived_{};          ///< arrival of the newest of them, or of their request
  std::uint32_t superseded_ = 0;
  LightChanges lights_;
};

}  // namespace farshade

#include "stereo/raster/depth_slots.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "stereo/link/frame_receiver.h"
#include "stereo/messages/messages.h"
#include "tests/support/packed.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

/// A session whose depth is kept twice: by DepthSlots, and as long as its record exists.
class DepthSession {
 public:
  static constexpr std::size_t kMost = 4;  ///< masks of a frame
  static constexpr Duration kPeriod = 14ms;

  explicit DepthSession(std::size_t records)
      : receiver_(records, kLayout), slots_(records), depth_of_record_(records) {
    receiver_.begin({});
  }

  void ask(std::uint32_t frame) {
    FrameRequest request;
    request.frame = {frame};
    for (View& view : request.views) view.size = kSize;
    static_cast<void>(receiver_.ask(request, Time(frame * kPeriod), Time(frame * kPeriod)));
    const std::size_t slot = receiver_.find({frame})->slot;
    ASSERT_TRUE(slots_.claim({frame}, slot).has_value());
    depth_of_record_[slot] = FrameId{frame};
  }

  /// One eye's mask comes: a single tile.
  void answer(std::uint32_t frame, Side eye) {
    ShadowFrame made{{frame}, kFirstLightSet, {}, {}};
    for (EyeMask& mask : made.masks) mask = EyeMask(kSize, kLayout);
    for (const std::vector<std::byte>& datagram : pack(packer_, made, {.frame = {frame}})) {
      const Decoded<ServerMessage> message = decode_server(datagram);
      const auto* const slice = std::get_if<Slice>(&*message);
      if (slice != nullptr && slice->eye == eye) receiver_.take(*slice, Time(0ms));
    }
  }

  /// Draws with the masks that were asked for up to the display time `until`, in the client's order.
  void draw(Time until) {
    std::vector<const RequestRecord*> usable = receiver_.received(until);
    const auto settled =
        std::ranges::find_if(usable, [&](const auto* record) { return receiver_.is_settled(*record); });
    if (settled != usable.end()) std::rotate(usable.begin(), settled, settled + 1);
    std::vector<TracedMask> masks;
    for (const RequestRecord* record : usable) masks.push_back(mask_of(*record));
    EXPECT_EQ(used(masks, [&](FrameId frame) { return slots_.find(frame).has_value(); }),
              used(masks, [&](FrameId frame) {
                return std::ranges::find(depth_of_record_, std::optional(frame)) != depth_of_record_.end();
              }));
    slots_.give_back_unused(masks, kMost);
  }

  [[nodiscard]] const DepthSlots& slots() const { return slots_; }

 private:
  template <class Has>
  static std::vector<std::uint32_t> used(const std::vector<TracedMask>& masks, const Has& has) {
    std::vector<std::uint32_t> frames;
    for (const TracedMask& mask : masks)
      if (frames.size() < kMost && has(mask.frame)) frames.push_back(mask.frame.value);
    return frames;
  }

  static constexpr Extent kSize{16, 16};
  static constexpr MaskLayout kLayout{1};

  FrameReceiver receiver_;
  DepthSlots slots_;
  std::vector<std::optional<FrameId>> depth_of_record_;  ///< by slot
  FramePacker packer_;
};

TEST(DepthSlots, KeepsEveryDepthThatAMaskIsUsedWith) {
  for (const std::uint32_t seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto below = [&](std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); };
    const std::uint32_t latency = 1 + below(12), jitter = below(10), lost_percent = below(60);
    const std::uint32_t delay = below(2) * latency;  // of virtual time, frames
    DepthSession session(5 + below(20));
    std::vector<std::vector<std::pair<std::uint32_t, Side>>> arrivals(600);
    for (std::uint32_t frame = 1; frame < 500; ++frame) {
      const bool silence = frame / 100 % 2 == 1;
      if (below(4) > 0) {
        session.ask(frame);
        for (const Side eye : kSides)
          if (below(100) >= (silence ? 98 : lost_percent))
            arrivals[frame + latency + (jitter > 0 ? below(jitter) : 0)].emplace_back(frame, eye);
      }
      for (const auto& [asked, eye] : arrivals[frame]) session.answer(asked, eye);
      session.draw(Time(frame * DepthSession::kPeriod) - delay * DepthSession::kPeriod);
    }
  }
}

TEST(DepthSlots, HasAsManyPlacesAsRequestsInFlightAndMasksInUse) {
  constexpr std::uint32_t kLatency = 5;
  DepthSession session(30);
  for (std::uint32_t frame = 1; frame < 200; ++frame) {
    session.ask(frame);
    if (frame > kLatency)
      for (const Side eye : kSides) session.answer(frame - kLatency, eye);
    session.draw(Time::max());
  }
  EXPECT_EQ(session.slots().places(), kLatency + DepthSession::kMost + 1)
      << "one more for the request of the frame itself";
}

TEST(DepthSlots, ARequestReplacesTheDepthOfItsSlot) {
  DepthSlots slots(2);
  EXPECT_EQ(slots.claim({1}, 0), 0u);
  EXPECT_EQ(slots.claim({2}, 1), 1u);
  EXPECT_EQ(slots.claim({3}, 0), 0u);
  EXPECT_FALSE(slots.find({1}).has_value());
  EXPECT_EQ(slots.find({3}), 0u);
  EXPECT_FALSE(slots.claim({4}, 2).has_value()) << "there is no such slot";
  slots.forget();
  EXPECT_FALSE(slots.find({2}).has_value());
  EXPECT_TRUE(slots.claim({5}, 1).has_value());
  EXPECT_EQ(slots.places(), 2u);
}

}  // namespace
}  // namespace farshade

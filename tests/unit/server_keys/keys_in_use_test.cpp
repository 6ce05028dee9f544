#include "rt_server/keys/keys_in_use.h"

#include <fstream>

#include "tests/support/virtual_link.h"
#include "tests/unit/answers_from.h"
#include "tests/unit/fetch/fetch_bench.h"

namespace farshade {
namespace {

constexpr std::chrono::sys_days kDay{std::chrono::year{2031} / 3 / 14};

/// A server for masks and for the scene, whose calendar the test turns.
class KeysInUseTest : public FetchTest {
 protected:
  void SetUp() override {
    write({{"a.glb", 1000}});
    serve();
    core_.emplace(Welcome{{1, 2, 3}, 2}, std::vector{key_},
                  masks_from([](const FrameRequest&, ShadowFrame&) { return TraceStats{}; }), link_.server(),
                  clock_);
  }

  /// `ring` need not be what is in the file.
  KeysInUse keys_in_use(std::vector<SharedKey> ring) {
    return {{ring_, FileWatch(ring_), std::move(ring)}, *core_, &*sender_, [this] { return today_; }};
  }

  [[nodiscard]] bool can_fetch(const SharedKey& key) const {
    FetchPlan wanted = plan();
    wanted.key = key;
    return ask_offer(wanted).has_value();
  }

  ManualClock clock_;
  VirtualLink link_{clock_, {}};
  std::optional<ServerCore> core_;
  std::filesystem::path ring_ = folder_.path() / "ring.keys";
  std::chrono::sys_days today_ = kDay;
};

TEST_F(KeysInUseTest, AKeyExpiresAtTheEndOfItsLastDay) {
  SharedKey lasting = new_key("lasting").value();
  key_.limits.until = kDay;
  KeysInUse keys = keys_in_use({key_, lasting});
  EXPECT_TRUE(can_fetch(key_));
  today_ += std::chrono::days(1);
  keys.look_again();
  EXPECT_FALSE(can_fetch(key_));
  EXPECT_TRUE(can_fetch(lasting));
}

TEST_F(KeysInUseTest, AKeyThatHasExpiredFetchesNothingFromTheBeginning) {
  key_.limits.until = kDay - std::chrono::days(1);
  const KeysInUse keys = keys_in_use({key_});
  EXPECT_FALSE(can_fetch(key_));
}

TEST_F(KeysInUseTest, NobodyFetchesWhileTheRingCannotBeReadWhichIsTriedAgain) {
  ASSERT_TRUE(append_to_ring(ring_, key_));
  KeysInUse keys = keys_in_use({key_});
  std::ofstream(ring_, std::ios::app) << "no key\n";
  keys.reload();
  EXPECT_FALSE(can_fetch(key_));
  std::filesystem::remove(ring_);
  ASSERT_TRUE(append_to_ring(ring_, key_));
  keys.look_again();
  EXPECT_TRUE(can_fetch(key_));
}

TEST_F(KeysInUseTest, ARingWithoutKeysIsReadAgainUntilItHasSome) {
  ASSERT_TRUE(append_to_ring(ring_, key_));
  KeysInUse keys = keys_in_use({});
  EXPECT_FALSE(can_fetch(key_));
  keys.look_again();
  EXPECT_TRUE(can_fetch(key_));
}

}  // namespace
}  // namespace farshade

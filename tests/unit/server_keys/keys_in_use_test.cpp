#include "rt_server/keys/keys_in_use.h"

#include <fstream>

#include "tests/support/virtual_link.h"
#include "tests/unit/answers_from.h"
#include "tests/unit/fetch/fetch_bench.h"
#include "tests/unit/link_client.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::sys_days kDay{std::chrono::year{2031} / 3 / 14};

/// A server for masks and for the scene, whose calendar the test turns.
class KeysInUseTest : public FetchTest {
 protected:
  void SetUp() override {
    write({{"a.glb", 1000}});
    serve();
    core_.emplace(link_test::kServed, std::vector{key_},
                  masks_from([](const FrameRequest&, ShadowFrame&) { return TraceStats{}; }), link_.server(),
                  clock_);
    link_.while_waiting([this] { link_test::serve(*core_); }, [this] { return core_->next_due(); });
    ASSERT_TRUE(append_to_ring(ring_, key_));
  }

  /// `ring` need not be what is in the file.
  KeysInUse keys_in_use(std::vector<SharedKey> ring) {
    return {{ring_, FileWatch(ring_), std::move(ring)}, *core_, &*sender_, [this] { return today_; }};
  }

  [[nodiscard]] bool can_fetch(const SharedKey& key) const {
    FetchPlan wanted = plan();
    wanted.key = key;
    const auto offer = ask_offer(wanted);
    EXPECT_TRUE(offer || offer.error().fault == Fault::Mismatch) << offer.error().what;
    return offer.has_value();
  }

  [[nodiscard]] bool can_connect(const SharedKey& key) {
    return link_test::PortClient(link_.client(), link_.server().local(), key, link_test::kServed).connect(1s);
  }

  void set_time_of_ring(Duration from_now) const {
    std::filesystem::last_write_time(ring_, std::filesystem::file_time_type::clock::now() + from_now);
  }

  ManualClock clock_;
  VirtualLink link_{clock_, {}};
  std::optional<ServerCore> core_;
  std::filesystem::path ring_ = folder_.path() / "ring.keys";
  std::chrono::sys_days today_ = kDay;
};

TEST_F(KeysInUseTest, AKeyExpiresAtTheEndOfItsLastDay) {
  const SharedKey lasting = new_key("lasting").value();
  key_.limits.until = kDay;
  KeysInUse keys = keys_in_use({key_, lasting});
  EXPECT_TRUE(can_fetch(key_));
  EXPECT_TRUE(can_connect(key_));
  today_ += std::chrono::days(1);
  keys.look_again();
  EXPECT_FALSE(can_fetch(key_));
  EXPECT_TRUE(can_fetch(lasting));
  EXPECT_EQ(core_->counters().sessions.expired, 1u);
  EXPECT_FALSE(can_connect(key_));
  EXPECT_TRUE(can_connect(lasting));
}

TEST_F(KeysInUseTest, AKeyThatHasExpiredIsRefusedFromTheBeginning) {
  const SharedKey lasting = new_key("lasting").value();
  key_.limits.until = kDay - std::chrono::days(1);
  const KeysInUse keys = keys_in_use({key_, lasting});
  EXPECT_FALSE(can_fetch(key_));
  EXPECT_FALSE(can_connect(key_));
  EXPECT_TRUE(can_fetch(lasting));
  EXPECT_TRUE(can_connect(lasting));
}

TEST_F(KeysInUseTest, NobodyIsAdmittedWhileTheRingCannotBeReadWhichIsTriedAgain) {
  KeysInUse keys = keys_in_use({key_});
  std::ofstream(ring_, std::ios::app) << "no key\n";
  keys.reload();
  EXPECT_FALSE(can_fetch(key_));
  EXPECT_FALSE(can_connect(key_));
  std::filesystem::remove(ring_);
  ASSERT_TRUE(append_to_ring(ring_, key_));
  keys.look_again();
  EXPECT_TRUE(can_fetch(key_));
  EXPECT_TRUE(can_connect(key_));
}

TEST_F(KeysInUseTest, ARingWithoutKeysIsReadAgainUntilItHasSome) {
  KeysInUse keys = keys_in_use({});
  EXPECT_FALSE(can_fetch(key_));
  keys.look_again();
  EXPECT_TRUE(can_fetch(key_));
}

/// A ring that is being written may be read by half when it is tried again. Its rest may come without a new
/// time of the file, as on file systems that count in seconds.
TEST_F(KeysInUseTest, ARingThatWasTriedWhileItWasWrittenIsReadOnceMore) {
  const SharedKey later = new_key("later").value();
  KeysInUse keys = keys_in_use({});
  set_time_of_ring(1s);
  const auto written = std::filesystem::last_write_time(ring_);
  keys.look_again();
  EXPECT_FALSE(can_fetch(later));
  ASSERT_TRUE(append_to_ring(ring_, later));
  std::filesystem::last_write_time(ring_, written);
  keys.look_again();
  EXPECT_TRUE(can_fetch(later));
}

TEST_F(KeysInUseTest, ARingThatHasChangedIsReadOnceWhenItStaysAsItIs) {
  const SharedKey later = new_key("later").value();
  KeysInUse keys = keys_in_use({key_});
  ASSERT_TRUE(append_to_ring(ring_, later));
  set_time_of_ring(1s);
  keys.look_again();
  EXPECT_FALSE(can_fetch(later));
  keys.look_again();
  EXPECT_TRUE(can_fetch(later));
  // What a signal has read is not read again.
  set_time_of_ring(2s);
  const auto read = std::filesystem::last_write_time(ring_);
  keys.reload();
  std::filesystem::remove(ring_);
  ASSERT_TRUE(append_to_ring(ring_, key_));
  std::filesystem::last_write_time(ring_, read);
  for (int looks = 0; looks < 3; ++looks) keys.look_again();
  EXPECT_TRUE(can_fetch(later));
}

TEST_F(KeysInUseTest, TheInsecureKeyIsAcceptedAlsoAfterASignal) {
  KeysInUse keys(load_keys(std::nullopt).value(), *core_, &*sender_);
  EXPECT_TRUE(can_fetch(insecure_key()));
  EXPECT_FALSE(can_fetch(key_));
  keys.reload();
  keys.look_again();
  EXPECT_TRUE(can_fetch(insecure_key()));
}

TEST(LoadKeys, ARingWithoutKeysIsAnErrorThatNamesTheCure) {
  const ScratchFolder folder;
  const std::filesystem::path ring = folder.path() / "ring.keys";
  ASSERT_TRUE(write_private_file(ring, "# all are revoked\n", IfThere::Refuse));
  const auto keys = load_keys(ring);
  ASSERT_FALSE(keys);
  EXPECT_EQ(keys.error().fault, Fault::Missing);
  EXPECT_NE(keys.error().what.find("contains no key: bring one with rt_server pair"), std::string::npos)
      << keys.error().what;
}

}  // namespace
}  // namespace farshade

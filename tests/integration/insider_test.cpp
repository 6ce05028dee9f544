// A real rt_server, a good client, and an attacker that holds a valid key of its own. The attacker plays what
// one key must not be able to do (insider_tools.h), each play four times; nightly it goes on for two minutes.
// The good client's masks stay the same in every bit, and hardly older than beside one honest neighbour; the
// server stays within its memory and ends cleanly.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "stereo/net/udp.h"
#include "tests/integration/good_client.h"
#include "tests/integration/insider_tools.h"
#include "tests/integration/test_keys.h"
#include "tests/support/nightly.h"
#include "tests/support/sanitized.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Duration kHonest = kSanitized ? 3s : 15s;
const Duration kAttack = std::chrono::seconds(kSanitized ? 20 : nightly(44, 132));  // a play takes 1 s
/// Both take turns, so that whatever else the machine does meanwhile falls upon both.
constexpr int kTurns = kSanitized ? 1 : 4;
constexpr Duration kInterval = std::chrono::microseconds(13'889);
constexpr Duration kPatience = 500ms;  ///< then the request counts as lost
/// For all. Without sanitizers as vr_client requests without --size.
constexpr Extent kSize = kSanitized ? Extent{128, 128} : Extent{512, 512};
constexpr int kMemory_MiB = 512;  ///< the server's limit

/// The ages of masks when they are complete, since their request, ms. A mask that did not come within
/// kPatience has that age.
struct Ages {
  std::vector<double> ms{};
  std::size_t lost = 0;

  void add(double age_ms) {
    ms.push_back(age_ms);
    if (age_ms >= ms_of(kPatience)) ++lost;
  }
  [[nodiscard]] double lost_share() const {
    return static_cast<double>(lost) / static_cast<double>(std::max<std::size_t>(ms.size(), 1));
  }
  [[nodiscard]] double of(double share) {
    std::ranges::sort(ms);
    return ms.empty() ? NAN : ms[static_cast<std::size_t>(share * static_cast<double>(ms.size() - 1))];
  }
};

class Insider : public testing::Test {
 protected:
  Insider() {
    const std::string& ring = test_keys().ring;
    for (const SharedKey& key : {neighbour_, attacker_})
      if (!append_to_ring(ring, key)) throw std::runtime_error("the ring cannot be written");
    server_.emplace(
        kRoom, "127.0.0.1:0",
        std::vector<std::string>{"--handshakes-per-second", "1000", "--memory", std::to_string(kMemory_MiB)});
    udp_ = connect_udp(server_->address()).value();
    target_ = target_of(udp_.server, test_keys().key, kRoom);
    good_.emplace(*udp_.port, target_, kSize);
    for (std::uint32_t pose = 0; pose < Walker::kPoses; ++pose) undisturbed_.push_back(*good_->next_masks());
  }

  /// The good client asks for masks at 72 Hz, or as fast as they come, and compares each with that of the
  /// undisturbed run.
  void walk(Duration span, const std::function<void(double age_ms)>& add,
            const std::function<void()>& each_second) {
    const SteadyClock clock;
    Time second = clock.now();
    for (const Time until = clock.now() + span; clock.now() < until && !HasFailure(); ++pose_) {
      const Time requested = clock.now();
      const auto masks = good_->next_masks(kPatience);
      if (masks) {
        EXPECT_EQ(*masks, undisturbed_[pose_ % Walker::kPoses]) << "pose " << pose_;
      }
      add(masks ? ms_of(clock.now() - requested) : ms_of(kPatience));
      if (clock.now() >= second + 1s) {
        second = clock.now();
        each_second();
      }
      std::this_thread::sleep_until(std::chrono::steady_clock::now() +
                                    std::max(Duration{}, requested + kInterval - clock.now()));
    }
  }

  void walk_beside_a_neighbour(Duration span, Ages& ages) {
    std::atomic<bool> over = false;
    std::jthread neighbour([&] {
      const UdpClient udp = connect_udp(udp_.server).value();
      LinkTarget target = target_;
      target.key = neighbour_;
      Walker walker(*udp.port, target, kSize);
      while (!over) {
        static_cast<void>(walker.next_masks(kPatience));
        std::this_thread::sleep_for(1ms);
      }
    });
    walk(
        span, [&](double age_ms) { ages.add(age_ms); }, [] {});
    over = true;
  }

  SharedKey neighbour_ = new_key("neighbour").value(), attacker_ = new_key("attacker").value();
  std::optional<RunningServer> server_;
  UdpClient udp_;
  LinkTarget target_;
  std::optional<Walker> good_;
  std::vector<PerEye<EyeMask>> undisturbed_;
  std::uint32_t pose_ = 0;
};

TEST_F(Insider, CostsAGoodClientNoMoreThanAnHonestNeighbourDoes) {
  Ages honest, attacked;
  walk_beside_a_neighbour(kHonest / kTurns, honest);
  const double memory_before = memory_KiB(server_->program().id());
  Welcome served;
  served.scene_hash = target_.scene_hash;
  served.light_count = target_.mask.lights;
  InsiderAttack attack(udp_.server, attacker_, served, udp_.port->local());
  double most_KiB = 0;
  std::array<Ages, InsiderAttack::kPlays> of_play;
  for (int turn = 1; (turn <= kTurns || attack.rounds() <= InsiderAttack::kPlays) && !HasFailure(); ++turn) {
    if (turn > 1) walk_beside_a_neighbour(kHonest / kTurns, honest);
    std::atomic<bool> over = false;
    const std::jthread attacker([&] { attack.run(over); });
    walk(
        kAttack / kTurns,
        [&](double age_ms) {
          attacked.add(age_ms);
          of_play[attack.rounds() % InsiderAttack::kPlays].add(age_ms);
        },
        [&] { most_KiB = std::max(most_KiB, memory_KiB(server_->program().id())); });
    over = true;
  }
  const Counts counts = counts_of(*server_);
  std::printf("%s\n", counts.line.c_str());
  std::printf(
      "age of masks, median and p90: %.1f and %.1f ms beside a neighbour (%zu masks, %zu lost), %.1f and "
      "%.1f ms beside the attacker (%zu, %zu lost)\n"
      "%lu hostile datagrams in %lu plays; the server's memory: %.0f MiB before, at most %.0f MiB\n",
      honest.of(0.5), honest.of(0.9), honest.ms.size(), honest.lost, attacked.of(0.5), attacked.of(0.9),
      attacked.ms.size(), attacked.lost, attack.sent(), attack.rounds(), memory_before / 1024,
      most_KiB / 1024);
  for (std::size_t i = 0; i < of_play.size(); ++i)
    std::printf("  %-24s %4zu masks, %3zu lost, age %6.1f and %6.1f ms\n", InsiderAttack::kNames[i].data(),
                of_play[i].ms.size(), of_play[i].lost, of_play[i].of(0.5), of_play[i].of(0.9));
  EXPECT_EQ(good_->counters().sessions, 1u) << "the good client kept its session";
  EXPECT_GT(attack.rounds(), 9u) << "each play once";
  EXPECT_GT(counts.of("counter jump"), 0u);
  // A sanitizer's heap keeps what was freed, and its server needs both cores for one client.
  if (!kSanitized) {
    EXPECT_GT(counts.of("stray parts of requests"), 0u);
    EXPECT_LT(attacked.lost_share(), 0.02 + honest.lost_share());
    EXPECT_LT((most_KiB - memory_before) / 1024, kMemory_MiB);
    EXPECT_LE(attacked.of(0.5), 1.5 * honest.of(0.5));
    EXPECT_LE(attacked.of(0.9), 1.5 * honest.of(0.9));
  }
  server_->program().send(SIGTERM);
  EXPECT_EQ(server_->program().wait(), 0);
}

}  // namespace
}  // namespace farshade

// Sends a million hostile datagrams to a real rt_server. The masks of its good client do not change, its
// memory does not grow, its counters contain each datagram, and no attacker receives more bytes than it sent.
// The attackers wait for the server after each batch: a full socket buffer loses the datagrams of all
// clients.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "stereo/net/udp.h"
#include "tests/integration/attack_tools.h"
#include "tests/integration/client_program.h"
#include "tests/integration/good_client.h"
#include "tests/integration/test_keys.h"
#include "tests/support/sanitized.h"

namespace farshade {
namespace {

constexpr std::uint64_t kAttacks = kSanitized ? 10'000 : 1'000'000;
/// Datagrams per batch. Together with the good client's they fit the kernel's usual socket buffer of 208 KiB.
constexpr int kBatch = 32;
constexpr std::uint64_t kSeed = 20'240'607;
const std::string kScene = FARSHADE_ASSETS "/box_over_plane.gltf";

/// A server, a good client with an attacker on its path, and the recorded datagrams of a client that has
/// left.
class Attack : public testing::Test {
 protected:
  void SetUp() override {
    target_ = target_of(udp_.server, test_keys().key, kScene);
    leave_a_ghost();
    good_.emplace(on_path_, target_);
    for (std::uint32_t pose = 0; pose < Walker::kPoses; ++pose) {
      const auto masks = good_->next_masks();
      ASSERT_TRUE(masks.has_value()) << pose;
      undisturbed_.push_back(*masks);
    }
    ASSERT_NE(undisturbed_.front(), undisturbed_.back());
  }

  /// Runs a genuine client to its end. Its address is then free for an attacker.
  void leave_a_ghost() {
    UdpClient udp = connect_udp(server_.address()).value();
    OnPath port(*udp.port, ghost_said_, kSeed);
    Walker walker(port, target_);
    for (int frames = 0; frames < 4; ++frames) ASSERT_TRUE(walker.next_masks().has_value());
    ghost_address_ = "127.0.0.1:" + std::to_string(udp.port->local().port);
  }

  /// The server's counters after it has handled everything sent before.
  Counts counts() {
    EXPECT_TRUE(strangers_->catch_up());
    return counts_of(server_);
  }

  void attack_by_strangers() {
    const auto ghost = listen_udp(ghost_address_);
    failed_ = !ghost.has_value();
    Random random(kSeed + 3);
    for (std::uint64_t sent = 0; sent < kAttacks && !failed_; sent += kBatch) {
      for (int i = 0; i < kBatch; ++i) strangers_->send_one();
      if (sent / kBatch % 32 == 0) {
        (*ghost)->send(udp_.server, ghost_said_.any_hello(random));
        (*ghost)->send(udp_.server, ghost_said_.any_sealed(random));
        ++from_ghost_.hellos;
        ++from_ghost_.sealed;
      }
      failed_ = !strangers_->catch_up();
      drain(**ghost);
    }
    if (ghost) strangers_->settle(**ghost);
  }

  /// Compares the server's counters with the datagrams that were sent between `before` and `after`.
  /// `calm`, `hellos` and `sealed`: the strangers' and the good client's datagrams before the attack.
  void check_counters(const Counts& before, const Counts& after, std::uint64_t calm, std::uint64_t hellos,
                      std::uint64_t sealed) {
    const auto more = [&](const std::string& what) { return after.of(what) - before.of(what); };
    Tally sent = strangers_->tally();
    sent += on_path_.tally();
    sent += from_ghost_;
    const std::uint64_t good_hellos = on_path_.hellos() - hellos, requests = on_path_.sealed() - sealed;
    EXPECT_GE(sent.total(), kAttacks);
    EXPECT_EQ(more("datagrams received"), sent.total() - calm + good_hellos + requests);
    EXPECT_EQ(more("requests"), requests);
    EXPECT_EQ(more("outdated"), 0u);
    EXPECT_EQ(more("clients"), 0u);
    EXPECT_EQ(more("moved"), 0u);
    EXPECT_EQ(more("truncated"), sent.truncated);
    EXPECT_EQ(more("magic"), sent.magic);
    EXPECT_EQ(more("version"), sent.version);
    EXPECT_EQ(more("type"), sent.type);
    EXPECT_EQ(more("padding"), sent.padding);
    EXPECT_EQ(more("of another version"), sent.foreign_version);
    EXPECT_EQ(more("without a cookie") + more("without a known key") + more("repeated"),
              sent.hellos - calm + good_hellos);
    EXPECT_GE(more("without a known key"), sent.false_proofs * 9 / 10);
    EXPECT_GE(more("repeated"), 1u);
    EXPECT_GE(more("unknown session"), sent.unknown_session);
    EXPECT_GE(more("replayed"), sent.replayed);
    // A forged counter that is far ahead is refused before the tag is checked.
    const std::uint64_t forged = more("forged") + more("counter jump");
    EXPECT_GE(forged, sent.forged);
    EXPECT_EQ(more("unknown session") + more("replayed") + forged, sent.sealed_of_any_kind());
    EXPECT_EQ(more("refused"), sent.total() - sent.hellos - sent.foreign_version);
  }

  RunningServer server_{kScene};
  UdpClient udp_ = connect_udp(server_.address()).value();
  LinkTarget target_;
  Overheard ghost_said_, good_said_;
  std::string ghost_address_;
  OnPath on_path_{*udp_.port, good_said_, kSeed + 1};
  std::optional<Walker> good_;
  std::vector<PerEye<EyeMask>> undisturbed_;
  std::optional<Strangers> strangers_;
  Tally from_ghost_;
  std::atomic<bool> failed_ = false;
};

TEST_F(Attack, ChangesNothingForAGoodClientNorInMemoryAndIsCounted) {
  strangers_.emplace(udp_.server, id_of(test_keys().key), good_said_, kSeed + 2);
  const Counts before = counts();
  const std::uint64_t calm = strangers_->tally().total();
  ASSERT_EQ(calm, strangers_->tally().hellos);
  const std::uint64_t hellos = on_path_.hellos(), sealed = on_path_.sealed();
  const double memory = memory_KiB(server_.program().id());

  on_path_.attack();
  std::atomic<bool> over = false;
  std::jthread attack([&] {
    attack_by_strangers();
    over = true;
  });
  std::uint64_t frames = 0;
  for (; !over || frames % Walker::kPoses != 0; ++frames) {
    const auto masks = good_->next_masks();
    ASSERT_TRUE(masks.has_value()) << "frame " << frames;
    ASSERT_EQ(*masks, undisturbed_[frames % Walker::kPoses]) << "frame " << frames;
  }
  attack.join();
  ASSERT_FALSE(failed_) << "the server does not answer a hello";
  const Counts after = counts();
  const double grown = memory_KiB(server_.program().id()) - memory;
  SCOPED_TRACE("seed " + std::to_string(kSeed) + "\nbefore: " + before.line + "\nafter: " + after.line);

  check_counters(before, after, calm, hellos, sealed);

  EXPECT_LE(strangers_->bytes_got(), strangers_->bytes_sent());
  EXPECT_EQ(strangers_->amplified(), 0u);
  EXPECT_EQ(strangers_->served(), 0u);
  drain(on_path_.elsewhere());
  const PortCounters elsewhere = on_path_.elsewhere().counters();
  EXPECT_GE(elsewhere.received, 1u);
  EXPECT_LE(elsewhere.received_bytes, elsewhere.sent_bytes);
  if (!kSanitized) {
    EXPECT_LT(grown, 1024) << "KiB";
  }
  std::printf(
      "%lu datagrams from %lu addresses; %lu frames of the good client; %lu bytes sent, %lu got; "
      "the server grew by %.0f KiB\n",
      strangers_->tally().total() - calm, strangers_->addresses(), frames, strangers_->bytes_sent(),
      strangers_->bytes_got(), grown);
  server_.program().send(SIGTERM);
  EXPECT_EQ(server_.program().wait(), 0);
}

}  // namespace
}  // namespace farshade

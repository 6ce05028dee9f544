/// Turns: which key's job begins next, and when. A value without threads or clocks.
///
/// The key on whose clients the least work was spent is next. A client asks again only when its answer has
/// come, so it pauses after each, and somebody else's job can begin in each of its pauses. Two rules keep
/// that from costing it its share. A key that pauses or is new may be as much work ahead of the others as
/// the last long job took, at least kBank. And after a long job, which has taken W while n other keys were
/// active, no other long job begins for W / n if an active key that is ahead may ask: in that time its jobs
/// begin at once. So a key gets its share although it pauses, the others lose no more than the share of one
/// key, and a key that is ahead waits for no more than the job that has begun.
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "rt_server/core/job_costs.h"
#include "stereo/wire/key_file.h"

namespace farshade {

class Turns {
 public:
  static constexpr Duration kBank = kMostTurn;
  /// A job that is expected to take no longer holds nobody up: 1.5 frames of a display at 72 Hz.
  static constexpr Duration kShortJob = std::chrono::milliseconds(20);
  /// A key is active while it waits, and for so long after a request or an answer: it may ask again.
  static constexpr Duration kActive = std::chrono::milliseconds(250);

  /// The accounts of keys that are not in `ring` end.
  void keep(const KeyRing& ring) {
    std::erase_if(accounts_, [&](const auto& entry) { return !ring.contains(entry.first); });
  }

  /// A client of `key` has asked, waits, or was answered.
  void was_active(const KeyId& key, Time now) { accounts_[key].active = now; }

  /// The key with the least is next: its work, and among equals when it was served.
  [[nodiscard]] std::pair<Duration, std::uint64_t> order(const KeyId& key) const;
  /// Until when a job of `key` does not begin, for the sake of a key that is ahead; nothing: it begins.
  [[nodiscard]] std::optional<Time> held_until(const KeyId& key, const JobSize& job) const;

  /// A job of `key` begins. Returns its number.
  std::uint64_t begin(const KeyId& key);
  /// It has ended, and took `work`.
  void end(const KeyId& key, Duration work, Time now);

  /// Jobs that have begun.
  [[nodiscard]] std::uint64_t jobs() const { return jobs_; }
  [[nodiscard]] JobCosts& costs(const KeyId& key) { return accounts_[key].costs; }

 private:
  struct Account {
    Duration work{};               ///< time of the worker
    std::uint64_t served = 0;      ///< number of the job that began last
    std::optional<Time> active{};  ///< when it was last
    JobCosts costs;
  };
  [[nodiscard]] Duration work_of(const Account& account) const {
    return std::max(account.work, level_ - bank_);
  }

  std::map<KeyId, Account> accounts_;
  std::uint64_t jobs_ = 0;
  Duration level_{};       ///< the most that a key had when its job began
  Duration bank_ = kBank;  ///< that a key may have less than that
  Time rests_until_{};     ///< no other long job begins before, if a key that is ahead may ask
};

}  // namespace farshade

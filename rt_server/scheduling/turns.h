/// Turns: which key's job begins next, and when. A value without threads or clocks.
///
/// The key on whose clients the least work was spent is next. A client asks again only when its answer has
/// come, so it pauses after each, and long jobs of others could begin in each of its pauses. So a key whose
/// jobs are long waits as long as an active key that has less work may ask, and the time in which the worker
/// waits is charged to that key as if it had used it: after as much time as it has less work it is no longer
/// waited for. So a key gets its share although it pauses, costs the others no more than its share whether
/// it asks or not, and waits for no more than the job that has begun while it has the least work.
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "rt_server/scheduling/job_costs.h"
#include "stereo/sealing/key_file.h"

namespace farshade {

class Turns {
 public:
  /// A key that had nothing to do is ahead of the others by so much work at most.
  static constexpr Duration kBank = kMostTurn;
  /// A job that takes no longer holds nobody up: 1.5 frames of a display at 72 Hz.
  static constexpr Duration kShortJob = std::chrono::milliseconds(20);
  /// The jobs of a key are long for so long after one that took longer.
  static constexpr Duration kLong = std::chrono::seconds(5);
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

  /// The worker looks for a job: what it waited since wait_for_others() is charged.
  void look(Time now);
  /// Whether no job of `key` begins now, for the sake of others.
  [[nodiscard]] bool is_held(const KeyId& key, Time now) const;
  /// Nothing begins at `now`, because all that could is held; of that, `key` has the least work.
  void wait_for_others(const KeyId& key, Time now);
  /// When the worker that waits has to look again because of a job of `key`; nothing: now.
  [[nodiscard]] std::optional<Time> look_at(const KeyId& key) const;

  /// A job of `key` begins. Returns its number.
  std::uint64_t begin(const KeyId& key);
  /// It has ended, and took `work`.
  void end(const KeyId& key, Duration work, Time now);

  /// Jobs that have begun.
  [[nodiscard]] std::uint64_t jobs() const { return jobs_; }
  [[nodiscard]] JobCosts& costs(const KeyId& key) { return accounts_[key].costs; }

 private:
  struct Account {
    Duration work{};                  ///< time of the worker, also such that it did not use
    std::uint64_t served = 0;         ///< number of the job that began last
    std::optional<Time> active{};     ///< when it was last
    std::optional<Time> last_long{};  ///< when a long job ended last
    bool is_awaited = false;          ///< the worker waits for it
    JobCosts costs;
  };
  [[nodiscard]] Duration work_of(const Account& account) const {
    return std::max(account.work, level_ - kBank);
  }

  std::map<KeyId, Account> accounts_;
  std::uint64_t jobs_ = 0;
  Duration level_{};  ///< the most that a key had when its job began
  struct Wait {
    Time since;
    Duration work;  ///< the least of a key that is held
  };
  std::optional<Wait> wait_;
};

}  // namespace farshade

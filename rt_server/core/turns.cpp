#include "rt_server/core/turns.h"

#include <algorithm>

namespace farshade {

std::pair<Duration, std::uint64_t> Turns::order(const KeyId& key) const {
  const auto found = accounts_.find(key);
  const Account& account = found == accounts_.end() ? Account{} : found->second;
  return {work_of(account), account.served};
}

std::optional<Time> Turns::held_until(const KeyId& key, const JobSize& job) const {
  const auto own = accounts_.find(key);
  if (own == accounts_.end() || own->second.costs.estimate(job) <= kShortJob) return std::nullopt;
  std::optional<Time> until;
  for (const auto& [other, account] : accounts_)
    if (account.active && work_of(account) < work_of(own->second))
      until = std::max(until.value_or(*account.active), *account.active + kActive);
  return until ? std::optional(std::min(*until, rests_until_)) : std::nullopt;
}

std::uint64_t Turns::begin(const KeyId& key) {
  Account& account = accounts_[key];
  account.work = work_of(account);
  level_ = std::max(level_, account.work);
  return account.served = ++jobs_;
}

void Turns::end(const KeyId& key, Duration work, Time now) {
  accounts_[key].work += work;
  was_active(key, now);
  if (work <= kShortJob) return;
  bank_ = std::max(kBank, work);
  const auto others = std::ranges::count_if(accounts_, [&](const auto& entry) {
    return entry.first != key && entry.second.active && now - *entry.second.active <= kActive;
  });
  rests_until_ = others > 0 ? now + work / others : now;
}

}  // namespace farshade

#include "rt_server/scheduling/turns.h"

#include <algorithm>

namespace farshade {

std::pair<Duration, std::uint64_t> Turns::order(const KeyId& key) const {
  const auto found = accounts_.find(key);
  const Account& account = found == accounts_.end() ? Account{} : found->second;
  return {work_of(account), account.served};
}

void Turns::look(Time now) {
  if (!wait_) return;
  for (auto& [key, account] : accounts_)
    if (std::exchange(account.is_awaited, false))
      account.work = std::min(work_of(account) + (now - wait_->since), wait_->work);
  wait_.reset();
}

bool Turns::is_held(const KeyId& key, Time now) const {
  const auto own = accounts_.find(key);
  if (own == accounts_.end() || !own->second.last_long || now - *own->second.last_long >= kLong) return false;
  return std::ranges::any_of(accounts_, [&](const auto& entry) {
    const Account& other = entry.second;
    return other.active && now - *other.active < kActive && work_of(other) < work_of(own->second);
  });
}

void Turns::wait_for_others(const KeyId& key, Time now) {
  wait_ = {now, order(key).first};
  for (auto& [other, account] : accounts_)
    account.is_awaited = account.active && now - *account.active < kActive && work_of(account) < wait_->work;
}

std::optional<Time> Turns::look_at(const KeyId& key) const {
  const auto own = accounts_.find(key);
  if (!wait_ || own == accounts_.end() || !own->second.last_long || work_of(own->second) < wait_->work)
    return std::nullopt;
  Time at = wait_->since;
  for (const auto& [other, account] : accounts_)
    if (account.is_awaited)
      at = std::max(at, std::min(*account.active + kActive, wait_->since + (wait_->work - work_of(account))));
  return std::min(at, *own->second.last_long + kLong);
}

std::uint64_t Turns::begin(const KeyId& key) {
  Account& account = accounts_[key];
  account.work = work_of(account);
  level_ = std::max(level_, account.work);
  return account.served = ++jobs_;
}

void Turns::end(const KeyId& key, Duration work, Time now) {
  Account& account = accounts_[key];
  account.work += work;
  account.active = now;
  if (work > kShortJob) account.last_long = now;
}

}  // namespace farshade

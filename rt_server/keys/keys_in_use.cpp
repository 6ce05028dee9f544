#include "rt_server/keys/keys_in_use.h"

#include <spdlog/spdlog.h>

#include <utility>

namespace farshade {
namespace {

constexpr Duration kBetweenComplaints = std::chrono::minutes(1);

Expected<std::vector<SharedKey>> read_keys(const KeySource& source) {
  if (source.ring.empty()) return std::vector{insecure_key()};
  Expected<std::vector<SharedKey>> ring = load_key_ring(source.ring);
  if (!ring && ring.error().fault == Fault::Missing)
    return fail(
        Fault::Missing,
        "no keys at " + source.ring.string() +
            ": bring the key of a client with rt_server pair, make one with rt_server keygen NAME, or name "
            "another ring with --keys");
  return ring;
}

std::string no_key_in(const KeySource& source) {
  return source.ring.string() +
         " contains no key: bring one with rt_server pair, or make one with rt_server keygen NAME";
}

}  // namespace

Expected<std::vector<SharedKey>> load_keys(const KeySource& source) {
  Expected<std::vector<SharedKey>> ring = read_keys(source);
  if (ring && ring->empty()) return fail(Fault::Missing, no_key_in(source));
  return ring;
}

std::vector<SharedKey> valid_on(std::chrono::sys_days day, std::vector<SharedKey> ring) {
  std::erase_if(ring, [&](const SharedKey& key) { return !is_valid_on(key, day); });
  return ring;
}

std::chrono::sys_days today_by_utc() {
  return std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now());
}

KeysInUse::KeysInUse(KeySource source, std::vector<SharedKey> ring, ServerCore& core, SceneSender* sender,
                     std::function<std::chrono::sys_days()> today)
    : source_(std::move(source)),
      ring_(std::move(ring)),
      core_(core),
      sender_(sender),
      today_(std::move(today)) {
  use();
}

void KeysInUse::reload() {
  Expected<std::vector<SharedKey>> ring = read_keys(source_);
  is_read_ = ring.has_value();
  if (ring) ring_ = *std::move(ring);
  use();
  if (is_read_ && !ring_.empty()) complaint_.clear();
  if (!is_read_)
    complain("nobody new is admitted, because the key ring cannot be read: " + ring.error().what);
  else if (ring_.empty())
    complain(no_key_in(source_));
  else
    spdlog::info("the key ring was read again: {} {}", ring_.size(), ring_.size() == 1 ? "key" : "keys");
}

void KeysInUse::look_again() {
  if (today_() != day_) use();
  if (!is_read_ || ring_.empty()) reload();
}

void KeysInUse::use() {
  day_ = today_();
  core_.set_ring(ring_, day_);
  core_.admit(is_read_ ? Newcomers::Admitted : Newcomers::Ignored);
  if (sender_ != nullptr) sender_->set_ring(is_read_ ? valid_on(day_, ring_) : std::vector<SharedKey>{});
}

void KeysInUse::complain(const std::string& what) {
  const SteadyClock clock;
  if (what == complaint_ && clock.now() < complained_ + kBetweenComplaints) return;
  spdlog::error(what);
  complaint_ = what;
  complained_ = clock.now();
}

}  // namespace farshade

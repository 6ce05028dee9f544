#include "rt_server/keys/keys_in_use.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "stereo/sealing/handshake.h"

namespace farshade {
namespace {

constexpr Duration kBetweenComplaints = std::chrono::minutes(1);

Expected<std::vector<SharedKey>> read_keys(const std::optional<std::filesystem::path>& file) {
  if (!file) return std::vector{insecure_key()};
  Expected<std::vector<SharedKey>> ring = load_key_ring(*file);
  if (!ring && ring.error().fault == Fault::Missing)
    return fail(
        Fault::Missing,
        "no keys at " + file->string() +
            ": bring the key of a client with rt_server pair, make one with rt_server keygen NAME, or name "
            "another ring with --keys");
  return ring;
}

std::string no_key_in(const std::filesystem::path& file) {
  return file.string() +
         " contains no key: bring one with rt_server pair, or make one with rt_server keygen NAME";
}

}  // namespace

Expected<LoadedKeys> load_keys(const std::optional<std::filesystem::path>& file) {
  const FileWatch watch(file.value_or(""));
  Expected<std::vector<SharedKey>> ring = read_keys(file);
  if (!ring) return tl::unexpected(ring.error());
  if (ring->empty()) return fail(Fault::Missing, no_key_in(*file));
  return LoadedKeys{file, watch, *std::move(ring)};
}

std::vector<SharedKey> valid_on(std::chrono::sys_days day, std::vector<SharedKey> ring) {
  std::erase_if(ring, [&](const SharedKey& key) { return !is_valid_on(key, day); });
  return ring;
}

std::chrono::sys_days today_by_utc() {
  return std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now());
}

KeysInUse::KeysInUse(LoadedKeys loaded, ServerCore& core, SceneSender* sender,
                     std::function<std::chrono::sys_days()> today)
    : loaded_(std::move(loaded)), core_(core), sender_(sender), today_(std::move(today)) {
  use();
}

void KeysInUse::reload() {
  loaded_.watch.mark_as_seen();
  read_again();
}

void KeysInUse::read_again() {
  auto& [file, watch, keys] = loaded_;
  Expected<std::vector<SharedKey>> ring = read_keys(file);
  is_read_ = ring.has_value();
  if (ring) keys = *std::move(ring);
  use();
  if (is_read_ && !keys.empty()) complaint_.clear();
  if (!is_read_)
    complain("nobody new is admitted, because the key ring cannot be read: " + ring.error().what);
  else if (keys.empty())
    complain(no_key_in(*file));
  else
    spdlog::info("the key ring was read again: {} {}", keys.size(), keys.size() == 1 ? "key" : "keys");
}

void KeysInUse::look_again() {
  if (today_() != day_) use();
  // This may read what is only half written, and is not marked as seen: then the watch reads the rest.
  if (!is_read_ || loaded_.ring.empty()) read_again();
  if (loaded_.file && loaded_.watch.has_changed()) read_again();
}

void KeysInUse::use() {
  day_ = today_();
  core_.set_ring(loaded_.ring, day_);
  core_.admit(is_read_ ? Newcomers::Admitted : Newcomers::Ignored);
  if (sender_ != nullptr)
    sender_->set_ring(is_read_ ? valid_on(day_, loaded_.ring) : std::vector<SharedKey>{});
}

void KeysInUse::complain(const std::string& what) {
  const SteadyClock clock;
  if (what == complaint_ && clock.now() < complained_ + kBetweenComplaints) return;
  spdlog::error(what);
  complaint_ = what;
  complained_ = clock.now();
}

}  // namespace farshade

#include "stereo/gpu/ledger.h"

#include <algorithm>
#include <utility>

namespace farshade::gpu {

std::string_view to_string(Use use) {
  static constexpr std::array<std::string_view, kUses> kNames{
      "vertices", "textures", "frame",     "G-buffer",    "depth",     "masks",   "motion",  "lists",
      "shown",    "report",   "read-back", "shadow maps", "edge rays", "staging", "uploads", "other"};
  return kNames[static_cast<std::size_t>(use)];
}

void Ledger::add(Use use, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  use_.now[use] += bytes;
  use_.peak[use] = std::max(use_.peak[use], use_.now[use]);
  use_.peak_total = std::max(use_.peak_total, use_.now.total() - use_.now[Use::Uploads]);
  ++use_.allocations;
}

void Ledger::remove(Use use, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  use_.now[use] -= bytes;
  --use_.allocations;
}

MemoryUse Ledger::read() const {
  const std::lock_guard lock(mutex_);
  return use_;
}

Charge::Charge(std::shared_ptr<Ledger> ledger, Use use, std::uint64_t bytes)
    : ledger_(std::move(ledger)), use_(use), bytes_(bytes) {
  ledger_->add(use_, bytes_);
}

Charge& Charge::operator=(Charge&& other) noexcept {
  if (this != &other) {
    end();
    ledger_ = std::move(other.ledger_);
    use_ = other.use_;
    bytes_ = other.bytes_;
  }
  return *this;
}

void Charge::end() {
  if (ledger_) ledger_->remove(use_, bytes_);
  ledger_.reset();
}

}  // namespace farshade::gpu

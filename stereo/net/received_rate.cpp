#include "stereo/net/received_rate.h"

#include <algorithm>

namespace farshade {

void ReceivedRate::add(Time arrived, std::size_t bytes) {
  const std::int64_t bucket = arrived.time_since_epoch() / kBucket;
  if (!any_ || bucket - newest_ >= kBuckets) {
    bytes_.fill(0);
    first_ = newest_ = bucket;
    any_ = true;
  }
  // A bucket before the first could be filled as well: no sum reaches it.
  if (newest_ - bucket >= kBuckets || bucket < first_) return;
  const auto slot = [&](std::int64_t i) -> std::uint64_t& {
    return bytes_[static_cast<std::size_t>((i % kBuckets + kBuckets) % kBuckets)];
  };
  while (newest_ < bucket) slot(++newest_) = 0;
  slot(bucket) += bytes;
}

std::optional<double> ReceivedRate::bytes_per_second() const {
  const std::int64_t full = std::min(newest_ - first_, kBuckets - 1);
  if (!any_ || full * kBucket < std::chrono::milliseconds(100)) return std::nullopt;
  std::uint64_t sum = 0;
  for (std::int64_t i = newest_ - full; i < newest_; ++i)
    sum += bytes_[static_cast<std::size_t>((i % kBuckets + kBuckets) % kBuckets)];
  return static_cast<double>(sum) / seconds_of(full * kBucket);
}

}  // namespace farshade

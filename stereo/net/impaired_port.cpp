#include "stereo/net/impaired_port.h"

#include <algorithm>
#include <atomic>

namespace farshade {
namespace {

/// Most datagrams to take in at once, so that a flood does not delay datagrams that are due.
constexpr int kMostTakenAtOnce = 1024;

class Impaired final : public ImpairedPort {
 public:
  Impaired(std::unique_ptr<DatagramPort> inner, const LinkModel& model, const Clock& clock,
           std::function<Time(Time)> own_time)
      : inner_(std::move(inner)), clock_(clock), own_time_(std::move(own_time)), path_(model, clock.now()) {}

  void follow(const LinkModel& model) override { path_.follow(model); }

  [[nodiscard]] Peer local() const override { return inner_->local(); }
  bool send(const Peer& to, std::span<const std::byte> bytes) override { return inner_->send(to, bytes); }

  [[nodiscard]] std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) override {
    const Time deadline = clock_.now() + wait;
    while (true) {
      for (int taken = 0; taken < kMostTakenAtOnce && take_in(Duration::zero());) ++taken;
      if (const auto due = hand_out(into)) return due;
      const Time now = clock_.now();
      if (now >= deadline || woken_.exchange(false)) return std::nullopt;
      const InTransit* const next = path_.front();
      take_in((next != nullptr ? std::min(next->arrival, deadline) : deadline) - now);
    }
  }

  void wake() override {
    woken_ = true;
    inner_->wake();
  }

  [[nodiscard]] PortCounters counters() const override {
    PortCounters counters = inner_->counters();
    counters.received = received_;
    counters.received_bytes = received_bytes_;
    counters.oversized += oversized_;
    return counters;
  }

 private:
  bool take_in(Duration wait) {
    const std::optional<Datagram> datagram = inner_->receive(buffer_, wait);
    if (datagram)
      path_.push(own_time_ ? own_time_(datagram->arrived) : datagram->arrived, datagram->from,
                 datagram->bytes);
    return datagram.has_value();
  }

  std::optional<Datagram> hand_out(std::span<std::byte> into) {
    for (const Time now = clock_.now(); path_.front() != nullptr && path_.front()->arrival <= now;) {
      const InTransit& item = *path_.front();
      path_.pop();
      if (item.size > into.size()) {
        ++oversized_;
        continue;
      }
      ++received_;
      received_bytes_ += item.size;
      std::ranges::copy(item.bytes(), into.begin());
      return Datagram{item.peer, into.first(item.size), item.arrival};
    }
    return std::nullopt;
  }

  std::unique_ptr<DatagramPort> inner_;
  const Clock& clock_;
  std::function<Time(Time)> own_time_;
  Impairment path_;
  std::array<std::byte, kMaxDatagram_bytes> buffer_;
  std::atomic<bool> woken_ = false;
  std::atomic<std::uint64_t> received_ = 0, received_bytes_ = 0, oversized_ = 0;
};

}  // namespace

std::unique_ptr<ImpairedPort> impaired(std::unique_ptr<DatagramPort> inner, const LinkModel& model,
                                       const Clock& clock, std::function<Time(Time)> own_time) {
  return std::make_unique<Impaired>(std::move(inner), model, clock, std::move(own_time));
}

}  // namespace farshade

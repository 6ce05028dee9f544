#include "stereo/net/virtual_link.h"

#include <algorithm>
#include <random>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/wire/messages.h"

namespace farshade {
namespace {

struct OnTheWay {
  Time arrival;
  std::uint64_t order = 0;
  std::size_t size = 0;
  std::array<std::byte, kMaxDatagram_bytes> bytes;
};

/// Heap order: the earliest on top.
constexpr auto kLater = [](const OnTheWay* a, const OnTheWay* b) {
  return a->arrival != b->arrival ? a->arrival > b->arrival : a->order > b->order;
};

/// One direction: datagrams by the time of their arrival, in memory that is used again.
class Direction {
 public:
  Direction(const LinkModel& model, std::uint64_t seed) : model_(model), random_(seed) {}

  /// False when kLinkCapacity datagrams are on the way already. What the model loses counts as sent.
  bool send(Time now, std::span<const std::byte> bytes) {
    // Both numbers are drawn for every datagram: another loss rate leaves the delays of the others as they
    // were.
    const bool lost = uniform() < model_.loss;
    const auto extra =
        Duration(static_cast<Duration::rep>(uniform() * static_cast<double>(model_.jitter.count())));
    if (lost) return true;
    if (queue_.size() == kLinkCapacity) return false;
    if (free_.empty()) free_.push_back(owned_.emplace_back(std::make_unique<OnTheWay>()).get());
    OnTheWay* const item = free_.back();
    free_.pop_back();
    item->arrival = now + model_.delay + extra;
    item->order = next_order_++;
    item->size = bytes.size();
    std::ranges::copy(bytes, item->bytes.begin());
    queue_.push_back(item);
    std::ranges::push_heap(queue_, kLater);
    return true;
  }

  [[nodiscard]] std::optional<Time> next_arrival() const {
    return queue_.empty() ? std::nullopt : std::optional(queue_.front()->arrival);
  }

  /// Tells datagrams apart; meaningful while next_arrival() is.
  [[nodiscard]] std::uint64_t front_order() const { return queue_.front()->order; }

  /// The earliest datagram; valid until the next send.
  std::span<const std::byte> take() {
    std::ranges::pop_heap(queue_, kLater);
    OnTheWay* const item = queue_.back();
    queue_.pop_back();
    free_.push_back(item);
    return std::span(item->bytes).first(item->size);
  }

 private:
  /// [0, 1). std's distributions differ between standard libraries; the engine does not.
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  LinkModel model_;
  std::mt19937_64 random_;
  std::uint64_t next_order_ = 0;
  std::vector<std::unique_ptr<OnTheWay>> owned_;
  std::vector<OnTheWay*> free_, queue_;
};

/// 2001:db8::/32 is for documentation (RFC 3849): no real peer has these addresses.
Peer virtual_peer(std::uint16_t port) {
  return {{0x20, 0x01, 0x0d, 0xb8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 0, port};
}

}  // namespace

struct VirtualLink::Impl {
  class Port;

  Impl(ManualClock& time, const LinkModels& models);

  [[nodiscard]] std::optional<Time> next_arrival() const {
    const std::optional<Time> a = to_server.next_arrival(), b = to_client.next_arrival();
    return a && b ? std::min(*a, *b) : a ? a : b;
  }

  ManualClock& clock;
  Direction to_server, to_client;
  std::function<void()> others;
  std::unique_ptr<Port> client, server;
};

class VirtualLink::Impl::Port final : public DatagramPort {
 public:
  Port(Impl& link, Direction& out, Direction& in, const Peer& local, const Peer& remote)
      : link_(link), out_(out), in_(in), local_(local), remote_(remote) {}

  [[nodiscard]] Peer local() const override { return local_; }

  bool send(const Peer& to, std::span<const std::byte> bytes) override {
    check(bytes.size() <= kMaxDatagram_bytes, "a datagram fits kMaxDatagram_bytes");
    if (to != remote_ || !out_.send(link_.clock.now(), bytes)) {
      ++counters_.unsent;
      return false;
    }
    ++counters_.sent;
    counters_.sent_bytes += bytes.size();
    return true;
  }

  [[nodiscard]] std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) override {
    const Time deadline = link_.clock.now() + wait;
    while (true) {
      while (arrived()) {
        const std::span<const std::byte> bytes = in_.take();
        if (bytes.size() > into.size()) {
          ++counters_.oversized;
          continue;
        }
        ++counters_.received;
        counters_.received_bytes += bytes.size();
        std::ranges::copy(bytes, into.begin());
        return Datagram{remote_, into.first(bytes.size())};
      }
      if (link_.clock.now() >= deadline || std::exchange(woken_, false)) return std::nullopt;
      pass_time(deadline);
    }
  }

  void wake() override { woken_ = true; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }

 private:
  [[nodiscard]] bool arrived() const {
    const std::optional<Time> next = in_.next_arrival();
    return next && *next <= link_.clock.now();
  }

  /// Moves the clock to what happens next, at most to `deadline`, and lets the far end see what reaches it.
  void pass_time(Time deadline) {
    const Time here = in_.next_arrival().value_or(deadline);
    const std::optional<Time> there = out_.next_arrival();
    const bool far_end =
        link_.others && there && *there <= std::min(here, deadline) && shown_ != out_.front_order();
    link_.clock.advance_to(far_end ? *there : std::min(here, deadline));
    if (!far_end) return;
    shown_ = out_.front_order();
    link_.others();
  }

  Impl& link_;
  Direction &out_, &in_;
  Peer local_, remote_;
  PortCounters counters_;
  bool woken_ = false;
  std::optional<std::uint64_t> shown_;  ///< the datagram that the far end was last told of
};

VirtualLink::Impl::Impl(ManualClock& time, const LinkModels& models)
    : clock(time),
      to_server(models.to_server, models.seed * 2),
      to_client(models.to_client, models.seed * 2 + 1),
      client(std::make_unique<Port>(*this, to_server, to_client, virtual_peer(1), virtual_peer(2))),
      server(std::make_unique<Port>(*this, to_client, to_server, virtual_peer(2), virtual_peer(1))) {}

VirtualLink::VirtualLink(ManualClock& clock, const LinkModels& models)
    : impl_(std::make_unique<Impl>(clock, models)) {}
VirtualLink::~VirtualLink() = default;

DatagramPort& VirtualLink::client() {
  return *impl_->client;
}
DatagramPort& VirtualLink::server() {
  return *impl_->server;
}
void VirtualLink::while_waiting(std::function<void()> others) {
  impl_->others = std::move(others);
}
std::optional<Time> VirtualLink::next_arrival() const {
  return impl_->next_arrival();
}

}  // namespace farshade

#include "tests/support/virtual_link.h"
#include "tests/support/manual_clock.h"

#include <algorithm>
#include <deque>
#include <unordered_map>
#include <utility>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/messages/messages.h"

namespace farshade {
namespace {

/// 2001:db8::/32 is for documentation (RFC 3849): no real peer has these addresses.
Peer virtual_peer(std::size_t host, std::size_t moves) {
  const auto byte = [](std::size_t value) { return static_cast<std::uint8_t>(value & 0xff); };
  return {{0x20, 0x01, 0x0d, 0xb8, 0, 0, 0, 0, 0, 0, byte(moves >> 16), byte(moves >> 8), byte(moves), 0,
           byte(host >> 8), byte(host)},
          0,
          7447};
}
constexpr std::size_t kServerHost = 1, kFirstClientHost = 2;

}  // namespace

struct VirtualLink::Impl {
  class Port;
  class ClientPort;
  class ServerPort;

  struct Direction {
    Impairment path;
    const Port* reader = nullptr;
    std::optional<std::uint64_t> shown;  ///< the last datagram for which the others were called
  };
  struct Client {
    std::unique_ptr<Port> port;
    Direction to_server, to_client;
    Peer address;
    std::size_t moves = 0;
  };

  Impl(ManualClock& time, const LinkModels& models, std::size_t count);

  /// Of the non-empty directions for which `matches` is true, the one whose datagram arrives first.
  template <class Matches>
  [[nodiscard]] Direction* first(const Matches& matches);

  void move(std::size_t i);

  ManualClock& clock;
  std::function<void()> others;
  std::function<std::optional<Time>()> due;
  std::unique_ptr<Port> server;
  std::deque<Client> clients;
  std::unordered_map<Peer, Client*> client_at;  ///< every address that a client has or had
  std::uint64_t lost_to_old_addresses = 0;
};

class VirtualLink::Impl::Port : public DatagramPort {
 public:
  explicit Port(Impl& link) : link_(link) {}

  bool send(const Peer& to, std::span<const std::byte> bytes) override {
    check(bytes.size() <= kMaxDatagram_bytes, "a datagram fits kMaxDatagram_bytes");
    if (!carry(to, bytes)) {
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
      Direction* const in = link_.first([this](const Direction& each) { return each.reader == this; });
      if (in != nullptr && in->path.front()->arrival <= link_.clock.now()) {
        if (const auto datagram = take(in->path, into)) return datagram;
        continue;
      }
      if (link_.clock.now() >= deadline || std::exchange(woken_, false)) return std::nullopt;
      pass_time(in != nullptr ? std::min(in->path.front()->arrival, deadline) : deadline);
    }
  }

  void wake() override { woken_ = true; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }

 protected:
  /// False: no client has this address, or too many datagrams are in transit.
  virtual bool carry(const Peer& to, std::span<const std::byte> bytes) = 0;

  Impl& link_;

 private:
  std::optional<Datagram> take(Impairment& path, std::span<std::byte> into) {
    const InTransit& item = *path.front();
    path.pop();
    if (item.size > into.size()) {
      ++counters_.oversized;
      return std::nullopt;
    }
    ++counters_.received;
    counters_.received_bytes += item.size;
    std::ranges::copy(item.bytes(), into.begin());
    return Datagram{item.peer, into.first(item.size), item.arrival};
  }

  /// Moves the clock to the next event, at most to `until`, and lets the others receive what reaches them.
  void pass_time(Time until) {
    Direction* const far = link_.first([this](const Direction& each) {
      return each.reader != this && each.shown != each.path.front()->order;
    });
    const bool arrives = link_.others && far != nullptr && far->path.front()->arrival <= until;
    const Time arrival = arrives ? far->path.front()->arrival : until;
    const std::optional<Time> due_at = link_.due ? link_.due() : std::nullopt;
    const bool is_due = due_at && *due_at <= arrival;
    link_.clock.advance_to(is_due ? *due_at : arrival);
    if (arrives && !is_due) far->shown = far->path.front()->order;
    if (arrives || is_due) link_.others();
  }

  PortCounters counters_;
  bool woken_ = false;
};

class VirtualLink::Impl::ClientPort final : public Port {
 public:
  ClientPort(Impl& link, Client& self) : Port(link), self_(self) {}
  [[nodiscard]] Peer local() const override { return self_.address; }

 private:
  bool carry(const Peer& to, std::span<const std::byte> bytes) override {
    return to == link_.server->local() && self_.to_server.path.push(link_.clock.now(), self_.address, bytes);
  }
  Client& self_;
};

class VirtualLink::Impl::ServerPort final : public Port {
 public:
  using Port::Port;
  [[nodiscard]] Peer local() const override { return virtual_peer(kServerHost, 0); }

 private:
  bool carry(const Peer& to, std::span<const std::byte> bytes) override {
    const auto found = link_.client_at.find(to);
    if (found == link_.client_at.end()) return false;
    Client& client = *found->second;
    if (client.address == to) return client.to_client.path.push(link_.clock.now(), local(), bytes);
    ++link_.lost_to_old_addresses;
    return true;
  }
};

VirtualLink::Impl::Impl(ManualClock& time, const LinkModels& models, std::size_t count)
    : clock(time), server(std::make_unique<ServerPort>(*this)) {
  check(count < 0xffff - kFirstClientHost, "clients have addresses");
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t stream = (models.seed << 16 | i) * 2;
    Client& client =
        clients.emplace_back(Client{nullptr,
                                    {Impairment(models.to_server, time.now(), stream), server.get(), {}},
                                    {Impairment(models.to_client, time.now(), stream + 1), nullptr, {}},
                                    virtual_peer(kFirstClientHost + i, 0)});
    client.port = std::make_unique<ClientPort>(*this, client);
    client.to_client.reader = client.port.get();
    client_at.emplace(client.address, &client);
  }
}

template <class Matches>
VirtualLink::Impl::Direction* VirtualLink::Impl::first(const Matches& matches) {
  Direction* best = nullptr;
  const auto consider = [&](Direction& each) {
    const InTransit* const front = each.path.front();
    if (front != nullptr && matches(each) && (!best || front->arrival < best->path.front()->arrival))
      best = &each;
  };
  for (Client& client : clients) {
    consider(client.to_server);
    consider(client.to_client);
  }
  return best;
}

void VirtualLink::Impl::move(std::size_t i) {
  Client& client = clients.at(i);
  client.address = virtual_peer(kFirstClientHost + i, ++client.moves);
  client_at.emplace(client.address, &client);
  for (Impairment& path = client.to_client.path; path.front() != nullptr; path.pop()) ++lost_to_old_addresses;
}

VirtualLink::VirtualLink(ManualClock& clock, const LinkModels& models, std::size_t clients)
    : impl_(std::make_unique<Impl>(clock, models, clients)) {}
VirtualLink::~VirtualLink() = default;

DatagramPort& VirtualLink::client(std::size_t i) {
  return *impl_->clients.at(i).port;
}
DatagramPort& VirtualLink::server() {
  return *impl_->server;
}
void VirtualLink::move_client(std::size_t i) {
  impl_->move(i);
}
std::uint64_t VirtualLink::lost_to_old_addresses() const {
  return impl_->lost_to_old_addresses;
}
void VirtualLink::while_waiting(std::function<void()> others, std::function<std::optional<Time>()> due) {
  impl_->others = std::move(others);
  impl_->due = std::move(due);
}
std::optional<Time> VirtualLink::next_arrival() const {
  const auto* const next = impl_->first([](const auto&) { return true; });
  return next == nullptr ? std::nullopt : std::optional(next->path.front()->arrival);
}

}  // namespace farshade

#include "stereo/sealing/seal.h"

#include <sodium.h>

#include <algorithm>
#include <limits>
#include <string_view>

#include "stereo/base/check.h"
#include "stereo/messages/timing.h"

namespace farshade {
namespace {

static_assert(kTag_bytes == crypto_aead_chacha20poly1305_ietf_ABYTES);
static_assert(Secret::size() == crypto_aead_chacha20poly1305_ietf_KEYBYTES);

using Nonce = std::array<std::uint8_t, crypto_aead_chacha20poly1305_ietf_NPUBBYTES>;

/// Four zero bytes, then the counter, little-endian.
Nonce nonce_of(std::uint64_t counter) {
  Nonce nonce{};
  for (std::size_t i = 0; i < 8; ++i) nonce[4 + i] = static_cast<std::uint8_t>(counter >> (8 * i));
  return nonce;
}

const std::uint8_t* octets(std::span<const std::byte> bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

/// Appends the sealed `message` to `out`. The tag also authenticates `around`.
void append_sealed(const Secret& key, Sealing sealing, std::uint64_t counter,
                   std::span<const std::byte> around, std::span<const std::byte> message,
                   std::vector<std::byte>& out) {
  const std::size_t start = out.size();
  out.resize(start + message.size() + kTag_bytes);
  auto* const to = reinterpret_cast<std::uint8_t*>(out.data() + start);
  if (sealing == Sealing::Off) {
    std::ranges::copy(message, out.begin() + static_cast<std::ptrdiff_t>(start));
    std::fill_n(to + message.size(), kTag_bytes, std::uint8_t{0});
    return;
  }
  const Nonce nonce = nonce_of(counter);
  crypto_aead_chacha20poly1305_ietf_encrypt(to, nullptr, octets(message), message.size(), octets(around),
                                            around.size(), nullptr, nonce.data(), key.data());
}

bool open_sealed(const Secret& key, Sealing sealing, std::uint64_t counter, std::span<const std::byte> around,
                 std::span<const std::byte> sealed, std::vector<std::byte>& message) {
  if (sealed.size() < kTag_bytes) return false;
  message.resize(sealed.size() - kTag_bytes);
  if (sealing == Sealing::Off) {
    std::ranges::copy(sealed.first(message.size()), message.begin());
    return std::ranges::all_of(sealed.last(kTag_bytes), [](std::byte b) { return b == std::byte{0}; });
  }
  const Nonce nonce = nonce_of(counter);
  return crypto_aead_chacha20poly1305_ietf_decrypt(reinterpret_cast<std::uint8_t*>(message.data()), nullptr,
                                                   nullptr, octets(sealed), sealed.size(), octets(around),
                                                   around.size(), nonce.data(), key.data()) == 0;
}

}  // namespace

Secret::~Secret() {
  sodium_memzero(bytes_.data(), bytes_.size());
}

Secret next_key(const Secret& key) {
  constexpr std::string_view kLabel = "farshade-7 next key";
  Secret next;
  crypto_generichash(next.data(), Secret::size(), octets(std::as_bytes(std::span(kLabel))), kLabel.size(),
                     key.data(), Secret::size());
  return next;
}

std::uint64_t Sealer::seal(std::span<const std::byte> message, std::vector<std::byte>& datagram) {
  check(message.size() <= kMaxMessage_bytes, "a message fits into a sealed datagram");
  check(next_ <= ReplayWindow::kMostCounter, "no session lasts that long");
  if (next_ - epoch_first_ >= most_) begin_epoch();
  const std::uint64_t counter = next_++;
  encode(Sealed{.session = session_, .counter = counter, .sealed = {}, .epoch = epoch_, .version = version_},
         datagram);
  datagram.reserve(kMaxDatagram_bytes);  // so that `around` is not reallocated
  append_sealed(key_, sealing_, counter, std::span(datagram).first(kSealedHeader_bytes), message, datagram);
  return counter;
}

void Sealer::renew(Time now) {
  if (!epoch_began_) epoch_began_ = now;
  if (now - *epoch_began_ <= kEpochTime) return;
  begin_epoch();
  epoch_began_ = now;
}

void Sealer::begin_epoch() {
  epoch_first_ = next_;
  if (epoch_ == std::numeric_limits<std::uint16_t>::max()) return;
  key_ = next_key(key_);
  ++epoch_;
}

Decoded<std::span<const std::byte>> Opener::open(const Sealed& sealed, std::span<const std::byte> datagram,
                                                 std::vector<std::byte>& opened) {
  const int step = int{sealed.epoch} - int{epoch_};
  if (window_.is_too_far(sealed.counter) || step > kMostEpochStep) return refuse(WireRefusal::CounterJump);
  if (!window_.is_new(sealed.counter) || step < -1 || (step == -1 && !last_key_))
    return refuse(WireRefusal::Replayed);
  Secret before = key_, key = step < 0 ? *last_key_ : key_;
  for (int i = 0; i < step; ++i) key = next_key(before = key);
  if (!open_sealed(key, sealing_, sealed.counter, datagram.first(kSealedHeader_bytes), sealed.sealed, opened))
    return refuse(WireRefusal::Forged);
  window_.take(sealed.counter);
  if (step > 0) {
    last_key_ = before;
    key_ = key;
    epoch_ = sealed.epoch;
    epoch_first_ = sealed.counter;
  }
  if (last_key_ && sealed.counter > epoch_first_ + kEpochGrace) last_key_.reset();
  return std::span<const std::byte>(opened);
}

std::vector<std::byte> seal_alone(const Secret& key, Sealing sealing, std::span<const std::byte> message) {
  std::vector<std::byte> sealed;
  append_sealed(key, sealing, 0, {}, message, sealed);
  return sealed;
}

bool open_alone(const Secret& key, Sealing sealing, std::span<const std::byte> sealed,
                std::vector<std::byte>& message) {
  return open_sealed(key, sealing, 0, {}, sealed, message);
}

}  // namespace farshade

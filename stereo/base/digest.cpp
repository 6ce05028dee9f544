#include "stereo/base/digest.h"

#include <sodium.h>

#include "stereo/base/check.h"

namespace farshade {

struct Digester::State {
  crypto_generichash_state hash;
};

Digester::Digester() : state_(std::make_unique<State>()) {
  check(sodium_init() >= 0, "libsodium starts");
  crypto_generichash_init(&state_->hash, nullptr, 0, sizeof(Digest));
}

Digester::Digester(Digester&&) noexcept = default;
Digester& Digester::operator=(Digester&&) noexcept = default;
Digester::~Digester() = default;

void Digester::add(std::span<const std::byte> bytes) {
  crypto_generichash_update(&state_->hash, reinterpret_cast<const unsigned char*>(bytes.data()),
                            bytes.size());
}

Digest Digester::finish() {
  Digest digest;
  crypto_generichash_final(&state_->hash, digest.data(), digest.size());
  return digest;
}

Digest digest_of(std::span<const std::byte> bytes) {
  Digester digester;
  digester.add(bytes);
  return digester.finish();
}

}  // namespace farshade

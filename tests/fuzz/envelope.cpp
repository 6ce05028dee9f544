// Envelopes: an arbitrary datagram before it is opened. It is refused, or it decodes to an envelope; encoding
// that gives the same bytes, and its sealed part is a view into them. The first byte selects the side that
// decodes.
#include "stereo/sealing/envelope.h"

#include <algorithm>

#include "tests/fuzz/target.h"

using namespace farshade;

namespace {

using Bytes = std::span<const std::byte>;

void check_is(const std::vector<std::byte>& encoded, Bytes datagram) {
  check(std::ranges::equal(encoded, datagram), "encoding gives the same bytes");
}

void check_tail(Bytes sealed, Bytes datagram, std::size_t header_bytes) {
  check_eq(sealed.size() + header_bytes, datagram.size(), "the sealed part is everything after the header");
  check(sealed.data() == datagram.data() + header_bytes, "and lies in the datagram");
  check(sealed.size() >= kTag_bytes, "and has a tag");
}

void check_spans(const auto&, Bytes) {}
void check_spans(const Sealed& sealed, Bytes datagram) {
  check_tail(sealed.sealed, datagram, kSealedHeader_bytes);
}
void check_spans(const Accept& accept, Bytes datagram) {
  check_tail(accept.sealed, datagram, kAcceptHeader_bytes);
}

void check_envelope(const auto& envelope, Bytes datagram) {
  check_spans(envelope, datagram);
  std::vector<std::byte> again;
  encode(envelope, again);
  check_is(again, datagram);
}

/// Only two fields are known of a hello of a version that a server does not speak.
void check_envelope(const ForeignHello& hello, Bytes datagram) {
  check_eq(datagram.size(), kBaseDatagram_bytes, "bytes of a hello in any version");
  check(!is_spoken(hello.version), "another version");
  check(std::ranges::equal(std::as_bytes(std::span(hello.echo)), datagram.subspan(7, hello.echo.size())),
        "the echo is where every version has it");
}

void check_any(const auto& envelope, Bytes datagram) {
  if (envelope) std::visit([&](const auto& e) { check_envelope(e, datagram); }, *envelope);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices choices(data, size);
  const bool from_client = choices.up_to(1) == 0;
  const Bytes datagram = choices.rest();
  if (from_client)
    check_any(open_client_envelope(datagram), datagram);
  else
    check_any(open_server_envelope(datagram), datagram);
  return 0;
}

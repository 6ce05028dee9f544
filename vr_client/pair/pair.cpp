#include "vr_client/pair/pair.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>

#include "stereo/net/tcp.h"
#include "stereo/pair/pairing.h"
#include "stereo/sealing/key_file.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

constexpr Duration kPatience = std::chrono::seconds(10);

std::string name_of_this_machine() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

/// The host of a code's address, for --server: there the port is another one.
std::string host_of(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  const bool has_port = colon != address.npos && !address.ends_with(']') && address.find(':') == colon;
  const bool has_port_v6 = colon != address.npos && address.find("]:") == colon - 1;
  return has_port || has_port_v6 ? address.substr(0, colon) : address;
}

}  // namespace

std::string key_name_of(std::string_view machine) {
  std::string name(machine.substr(0, kMaxKeyName));
  for (char& c : name)
    if (!is_sound(SharedKey{std::string(1, c), {1}})) c = '-';
  return name.empty() ? "client" : name;
}

void add_pair(CLI::App& program, ClientPairOptions& options) {
  CLI::App* command = program.add_subcommand(
      "pair", "Makes a key and brings it to the server whose rt_server pair shows the code.");
  command->add_option("code", options.code, "the code, such as farshade://192.0.2.2/XXXX-XXXX-XXXX-XXXX-XXXX")
      ->required();
  command->add_option("--key", options.key,
                      "key file to make (default: " + default_key_path().string() + ")");
  command->add_option(
      "--name", options.name,
      "name of this client in the server's log: A-Z a-z 0-9 . _ - (default: this machine's name)");
}

Expected<std::string> pair_with_server(const ClientPairOptions& options) {
  const Expected<PairingCode> code = parse_pairing_code(options.code);
  if (!code) return tl::unexpected(code.error());
  const Expected<SharedKey> key =
      new_key(options.name.empty() ? key_name_of(name_of_this_machine()) : options.name);
  if (!key) return tl::unexpected(key.error());
  const fs::path file = options.key.empty() ? default_key_path() : fs::path(options.key);
  // First, so that no server has a key that its client could not keep.
  if (const Expected<void> written = write_key(file, *key); !written)
    return fail(written.error().fault, written.error().what + (written.error().fault == Fault::Unavailable
                                                                   ? "; name another file with --key FILE"
                                                                   : ""));
  if (const Expected<void> paired = pair_with(*code, *key, {SteadyClock().now() + kPatience}); !paired) {
    std::error_code ignored;
    fs::remove(file, ignored);  // made by this call: write_key never overwrites
    return tl::unexpected(paired.error());
  }
  const std::string server = host_of(code->address);
  const std::string with_key = options.key.empty() ? "" : " --key " + file.string();
  return fmt::format("paired with {}: the key '{}' is in {}\nnext: vr_client doctor --server {}{}\n", server,
                     key->name, file.string(), server, with_key);
}

}  // namespace farshade

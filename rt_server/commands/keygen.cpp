#include "rt_server/commands/commands.h"

#include <CLI/CLI.hpp>

#include "stereo/options/within.h"
#include "stereo/sealing/key_file.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// Writes both files, or neither.
Expected<void> write_both(const fs::path& file, const fs::path& ring, const SharedKey& key,
                          const KeyLimits& limits) {
  return write_key(file, key).and_then([&] {
    SharedKey limited = key;
    limited.limits = limits;
    Expected<void> added = append_to_ring(ring, limited);
    std::error_code ignored;
    if (!added) fs::remove(file, ignored);  // made by this call: write_key never overwrites
    return added;
  });
}

}  // namespace

void add_keygen(CLI::App& program, KeygenOptions& options) {
  CLI::App* command = program.add_subcommand("keygen", "Makes a key for a client and adds it to the ring.");
  command->add_option("name", options.name, "name of the client in the server's log: A-Z a-z 0-9 . _ -")
      ->required();
  command->add_option("--key", options.key, "the client's key file; default " + default_key_path().string());
  command->add_option("--ring", options.ring,
                      "the server's key ring; default " + default_ring_path().string());
  command
      ->add_option("--until", options.until,
                   "the last day (UTC) on which the server takes the key, for example 2027-01-31")
      ->type_name("DAY")
      ->check([](const std::string& text) {
        return parse_day(text) ? std::string() : "'" + text + "' is no day like 2027-01-31";
      });
  command->add_option("--sessions", options.sessions, "maximum number of clients with this key at one time")
      ->check(within(1, KeyLimits::kMostSessions));
  command
      ->add_option("--bytes-per-second", options.bytes_per_second,
                   "maximum number of bytes per second that the server sends to all clients with this key")
      ->check(within(KeyLimits::kLeastBytesPerSecond, KeyLimits::kMostBytesPerSecond));
}

Expected<std::string> keygen(const KeygenOptions& options) {
  const fs::path file = options.key.empty() ? default_key_path() : fs::path(options.key);
  const fs::path ring = options.ring.empty() ? default_ring_path() : fs::path(options.ring);
  const Expected<SharedKey> key = new_key(options.name);
  if (!key) return tl::unexpected(key.error());
  KeyLimits limits{.until = parse_day(options.until)};
  if (options.sessions != 0) limits.sessions = options.sessions;
  if (options.bytes_per_second != 0) limits.bytes_per_second = options.bytes_per_second;
  if (const Expected<void> written = write_both(file, ring, *key, limits); !written) {
    if (written.error().fault == Fault::Unavailable && options.key.empty() && fs::exists(file))
      return fail(Fault::Unavailable, written.error().what + "; name another file with --key FILE");
    return tl::unexpected(written.error());
  }
  return "key of '" + key->name + "': " + file.string() + "\nring: " + ring.string() +
         "\nnext: copy the key to the client, e.g. scp " + file.string() +
         " CLIENT:.config/farshade/client.key" +
         "\n      whoever has this file can connect: keep its mode 0600\n";
}

}  // namespace farshade

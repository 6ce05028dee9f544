// Runs a fuzz target on each file of its corpus, without libFuzzer. Each input has its own allocation of
// exactly its size, so that a sanitizer sees reads beyond its end.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "stereo/base/files.h"
#include "tests/fuzz/target.h"

int main(int argc, char** argv) {
  using namespace farshade;
  if (argc != 2) return std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]), EXIT_FAILURE;
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    std::printf("%s\n", entry.path().c_str());
    std::fflush(stdout);  // if the target fails, the last printed name is its input
    const auto bytes = read_file(entry.path(), 1u << 20);
    check(bytes.has_value(), "a seed is readable");
    const auto exact = std::make_unique<std::uint8_t[]>(bytes->size());
    for (std::size_t i = 0; i < bytes->size(); ++i) exact[i] = static_cast<std::uint8_t>((*bytes)[i]);
    LLVMFuzzerTestOneInput(exact.get(), bytes->size());
    ++files;
  }
  std::printf("%d inputs\n", files);
  return files > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

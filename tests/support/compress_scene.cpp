// Compresses a GLB without loss, and compares how long the plain and the compressed file take to load.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "stereo/base/files.h"
#include "stereo/gltf/gltf.h"
#include "tests/support/gltf_compressor.h"

using namespace farshade;

namespace {

struct Loading {
  std::vector<double> ms;
  std::uint64_t triangles = 0;
};

void load_once(const std::filesystem::path& path, Loading& loading) {
  const auto start = std::chrono::steady_clock::now();
  const Expected<Scene> scene = load_scene(path);
  loading.ms.push_back(
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  if (!scene) throw std::runtime_error(scene.error().what);
  loading.triangles = scene->triangle_count;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void compare(const std::filesystem::path& plain, const std::filesystem::path& packed, int rounds) {
  Loading of_plain, of_packed;
  for (int i = 0; i < rounds; ++i) {
    load_once(plain, of_plain);
    load_once(packed, of_packed);
  }
  const double a = median(of_plain.ms), b = median(of_packed.ms);
  fmt::print("plain      {:>10} bytes {:8.1f} ms {} triangles\n", file_size(plain), a, of_plain.triangles);
  fmt::print("compressed {:>10} bytes {:8.1f} ms {} triangles: {:.2f} x\n", file_size(packed), b,
             of_packed.triangles, b / a);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app{"Compresses a GLB without loss, and says how long both files take to load (medians)."};
  std::filesystem::path from, to;
  std::string codec = "meshopt";
  int rounds = 11;
  app.add_option("from", from, "GLB file")->required();
  app.add_option("to", to, "compressed GLB file to write")->required();
  app.add_option("--codec", codec, "meshopt or draco")->check(CLI::IsMember({"meshopt", "draco"}));
  app.add_option("--rounds", rounds, "how often each file is loaded, in turns")->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  const auto bytes = read_file(from, std::uint64_t{1} << 31).value();
  const auto packed = codec == "draco" ? compress_with_draco(bytes, DracoMethod::Edgebreaker)
                                       : compress_with_meshopt(bytes, IndexCodec::Triangles);
  if (const auto written = write_file_atomically(to, std::span<const std::byte>(packed)); !written)
    throw std::runtime_error(written.error().what);
  compare(from, to, rounds);
} catch (const std::exception& error) {
  return std::fprintf(stderr, "compress_scene: %s\n", error.what()), EXIT_FAILURE;
}

#include "tests/integration/client_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/integration/test_keys.h"

namespace farshade {

RunningServer::RunningServer(const std::string& scene, const std::string& listen,
                             const std::vector<std::string>& more)
    : program_([&] {
        std::vector<std::string> arguments{RT_SERVER, "--scene", scene,           "--listen",
                                           listen,    "--keys",  test_keys().ring};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
      }()) {
  const auto address = program_.line_after("rt_server: listening on ");
  if (!address) throw std::runtime_error("rt_server does not listen: " + program_.errors());
  address_ = *address;
}

std::vector<std::string> client_arguments(const std::map<std::string, std::string>& options) {
  std::map<std::string, std::string> all = options;
  all.insert({{"--scene", kRoom},
              {"--trace", kWalk},
              {"--size", std::to_string(kClientSize.width) + "x" + std::to_string(kClientSize.height)},
              {"--frames", "8"},
              {"--key", test_keys().client}});
  // The Vulkan loader unloads drivers at the end. A leak suppression cannot name a module that is unloaded.
  std::vector<std::string> arguments{"/usr/bin/env", "LSAN_OPTIONS=detect_leaks=0", VR_CLIENT};
  for (const auto& [name, value] : all) {
    arguments.push_back(name);
    if (!value.empty()) arguments.push_back(value);
  }
  return arguments;
}

Ended run_client(const std::map<std::string, std::string>& options) {
  ChildProgram program(client_arguments(options));
  const std::string errors = program.errors();
  return {program.wait(), errors};
}

Csv read_csv(const std::filesystem::path& path) {
  const auto fields = [](const std::string& line) {
    std::vector<std::string> found(1);
    for (const char c : line)
      if (c == ',')
        found.emplace_back();
      else
        found.back() += c;
    return found;
  };
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const std::vector<std::string> names = fields(line);
  Csv csv;
  while (std::getline(file, line)) {
    const std::vector<std::string> row = fields(line);
    EXPECT_EQ(row.size(), names.size()) << path << ": " << line;
    for (std::size_t i = 0; i < std::min(row.size(), names.size()); ++i) csv[names[i]].push_back(row[i]);
  }
  return csv;
}

std::vector<double> summary_row(const std::filesystem::path& out, const std::string& group,
                                const std::string& metric) {
  const Csv summary = read_csv(out / "summary.csv");
  for (std::size_t row = 0; summary.contains("group") && row < summary.at("group").size(); ++row) {
    if (summary.at("group")[row] != group || summary.at("metric")[row] != metric) continue;
    std::vector<double> values;
    for (const char* column : {"median", "p95", "p99"}) {
      values.push_back(std::stod(summary.at(column)[row]));
      EXPECT_TRUE(std::isfinite(values.back())) << group << " " << metric;
    }
    return values;
  }
  ADD_FAILURE() << "no " << group << " " << metric << " in " << out / "summary.csv";
  return {NAN, NAN, NAN};
}

std::vector<std::string> files_below(const std::filesystem::path& folder) {
  std::vector<std::string> found;
  if (!std::filesystem::is_directory(folder)) return found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (!entry.is_directory()) found.push_back(entry.path().lexically_relative(folder).generic_string());
  std::ranges::sort(found);
  return found;
}

}  // namespace farshade

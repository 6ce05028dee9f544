/// docs/limits.md says what happens with each extension and property of glTF. It happens.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "stereo/gltf/gltf_extensions.h"
#include "tests/unit/gltf/gltf_builder.h"

namespace farshade {
namespace {

using nlohmann::json;

struct Row {
  std::vector<std::string> names;  ///< in backticks, of the first cell
  std::vector<std::string> cells;
};

/// The rows of the table below a heading of docs/limits.md.
std::vector<Row> rows_below(const std::string& heading) {
  std::ifstream file(FARSHADE_SOURCE "/docs/limits.md");
  std::vector<Row> rows;
  bool is_here = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#")) is_here = line == heading;
    if (!is_here || !line.starts_with("| `")) continue;
    Row row;
    std::istringstream cells(line.substr(1));
    for (std::string cell; std::getline(cells, cell, '|');)
      row.cells.push_back(std::regex_replace(cell, std::regex("^ +| +$"), ""));
    const std::regex name("`([^`]+)`");
    const std::string& first = row.cells.at(0);
    for (std::sregex_iterator at(first.begin(), first.end(), name), end; at != end; ++at)
      row.names.push_back((*at)[1]);
    rows.push_back(row);
  }
  return rows;
}

GltfBuilder file_with(const std::string& extension) {
  GltfBuilder file = triangle_file();
  file.json["extensionsUsed"] = {extension};
  return file;
}

std::vector<std::string> warnings_of(const GltfBuilder& file) {
  const auto scene = load(file);
  EXPECT_TRUE(scene) << scene.error().what;
  return scene ? scene->warnings : std::vector<std::string>();
}

TEST(LimitsTable, SaysWhatHappensWithEachExtension) {
  std::set<std::string> names;
  for (const Row& row : rows_below("### Extensions"))
    for (const std::string& in_table : row.names) {
      EXPECT_TRUE(names.insert(in_table).second) << in_table << " is there twice";
      const std::string name = std::regex_replace(in_table, std::regex("\\*"), "something");
      GltfBuilder file = file_with(name);
      const auto warnings = warnings_of(file);
      const std::string& says = row.cells.at(1);
      const bool warns = says.starts_with("warning") && !says.starts_with("warning where used");
      EXPECT_TRUE(warns || says.starts_with("warning where used") || says.starts_with("read") ||
                  says == "no effect")
          << says;
      ASSERT_EQ(warnings.size(), warns ? 1u : 0u) << name;
      if (warns) {
        EXPECT_TRUE(warnings[0].starts_with(name + " is not drawn: ")) << warnings[0];
      }
      file.json["extensionsRequired"] = {name};
      EXPECT_EQ(load(file).has_value(), row.cells.at(2) == "yes") << name;
    }
  EXPECT_GT(names.size(), 60u);
  for (const std::string_view known : gltf::known_extensions()) {
    std::string name(known);
    if (name.ends_with('_')) name += '*';
    EXPECT_TRUE(names.contains(name)) << name << " is not in the table";
  }
}

TEST(LimitsTable, OtherExtensionsGetOneWarningTogether) {
  GltfBuilder file = file_with("VENDOR_b");
  file.json["extensionsUsed"] = {"VENDOR_b", "KHR_materials_sheen", "VENDOR_a", "KHR_materials_ior",
                                 "VENDOR_a"};
  EXPECT_EQ(warnings_of(file),
            (std::vector<std::string>{
                "KHR_materials_ior, KHR_materials_sheen are not drawn: materials have base colours only",
                "VENDOR_a, VENDOR_b are not drawn: unknown"}));
  file.json["extensionsRequired"] = {"VENDOR_a"};
  EXPECT_FALSE(load(file));
}

/// A use of each property that gives a warning, as a patch of a file with a triangle and a material.
const std::map<std::string, json> kWarned = {
    {"material.alphaMode",
     {{"materials",
       {{{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.7}}}}}}}}},
    {"material.normalTexture", {{"materials", {{{"normalTexture", {{"index", 0}}}}}}}},
    {"material.occlusionTexture", {{"materials", {{{"occlusionTexture", {{"index", 0}}}}}}}},
    {"material.pbrMetallicRoughness.metallicFactor",
     {{"materials", {{{"pbrMetallicRoughness", {{"metallicFactor", 0.5}}}}}}}},
    {"material.pbrMetallicRoughness.roughnessFactor",
     {{"materials", {{{"pbrMetallicRoughness", {{"roughnessFactor", 0.5}}}}}}}},
    {"material.pbrMetallicRoughness.metallicRoughnessTexture",
     {{"materials", {{{"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 0}}}}}}}}}},
    {"material.emissiveFactor", {{"materials", {{{"emissiveFactor", {0, 0.5, 0}}}}}}},
    {"primitive.mode",
     {{"meshes", {nullptr, {{"primitives", {{{"attributes", json::object()}, {"mode", 1}}}}}}}}},
    {"primitive.attributes.JOINTS_1",
     {{"meshes", {nullptr, {{"primitives", {{{"attributes", {{"JOINTS_1", 0}}}}}}}}}}},
    {"primitive.targets.COLOR_0",
     {{"meshes",
       {nullptr, {{"primitives", {{{"attributes", json::object()}, {"targets", {{{"COLOR_0", 0}}}}}}}}}}}},
    {"primitive.targets.TEXCOORD_0",
     {{"meshes",
       {nullptr, {{"primitives", {{{"attributes", json::object()}, {"targets", {{{"TEXCOORD_0", 0}}}}}}}}}}}},
    {"sampler.magFilter", {{"samplers", {{{"magFilter", 9728}}}}}},
};

TEST(LimitsTable, SaysWhichPropertiesGiveAWarning) {
  std::set<std::string> names;
  for (const Row& row : rows_below("### Properties")) {
    const std::string& says = row.cells.at(1);
    EXPECT_TRUE(says.starts_with("obeyed") || says.starts_with("warning") || says.starts_with("no effect") ||
                says.starts_with("messages only"))
        << says;
    if (says.starts_with("warning")) names.insert(row.names.begin(), row.names.end());
  }
  for (const auto& [name, patch] : kWarned) {
    EXPECT_EQ(names.erase(name), 1u) << name << " is not in the table";
    GltfBuilder file = triangle_file();
    json more = patch;
    if (more.contains("meshes")) more["meshes"][0] = file.json["meshes"][0];
    file.json.update(more);
    const auto warnings = warnings_of(file);
    EXPECT_EQ(warnings.size(), 1u) << name;
  }
  for (const std::string& name : names) ADD_FAILURE() << name << " has no sample";
}

TEST(LimitsTable, AWarningNamesTheFirstAndCountsTheOthers) {
  GltfBuilder file = triangle_file();
  const json glowing = {{"emissiveFactor", {1, 1, 1}}};
  file.json["materials"] = {json::object(), glowing, glowing, glowing};
  file.json["materials"][1]["name"] = "lamp";
  EXPECT_EQ(warnings_of(file),
            std::vector<std::string>{"material 1 'lamp' (and 2 more) emits light: surfaces do not glow"});
}

TEST(LimitsTable, DullOpaqueMaterialsGiveNoWarning) {
  GltfBuilder file = triangle_file();
  file.json["materials"] = {{{"alphaMode", "BLEND"},
                             {"emissiveFactor", {0, 0, 0}},
                             {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}}};
  EXPECT_EQ(warnings_of(file), std::vector<std::string>{});
}

/// Any types, as nothing is checked yet.
TEST(LimitsTable, WarningsOfMalformedFilesAreNoFault) {
  for (const json& wrong : {json(3), json("text"), json::array({1, "a", nullptr}), json::object({{"a", 1}}),
                            json::array({{{"primitives", 5}, {"pbrMetallicRoughness", "x"}}}),
                            json::array({{{"primitives", {3, {{"mode", "x"}, {"targets", {7}}}}},
                                          {"name", 7},
                                          {"emissiveFactor", {"x"}},
                                          {"extensions", 7}}})})
    for (const char* list : {"extensionsUsed", "materials", "meshes", "samplers"})
      EXPECT_LE(gltf::look_warnings(json::object({{list, wrong}})).size(), 3u) << list << " " << wrong;
  EXPECT_TRUE(gltf::look_warnings(json(7)).empty());
}

/// A window in front of a floor.
TEST(Transmission, AboveAHalfIsAHoleAndBelowItIsOpaque) {
  for (const double factor : {0.0, 0.5, 0.51, 1.0}) {
    GltfBuilder file = triangle_file();
    file.json["meshes"][0]["primitives"][0]["material"] = 0;
    file.json["materials"] = {
        {{"name", "pane"},
         {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", factor}}}}}}};
    file.json["extensionsUsed"] = {"KHR_materials_transmission"};
    const auto scene = load(file);
    ASSERT_TRUE(scene) << scene.error().what;
    const Material& material = scene->materials[0];
    const bool is_hole = material.alpha_cutoff && material.base_color.a < *material.alpha_cutoff;
    EXPECT_EQ(is_hole, factor > 0.5) << factor;
    ASSERT_EQ(scene->warnings.size(), factor > 0 ? 1u : 0u);
    if (factor > 0) {
      EXPECT_TRUE(scene->warnings[0].starts_with("material 0 'pane' lets light through")) << factor;
    }
  }
}

}  // namespace
}  // namespace farshade

#include "stereo/options/config_file.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>

#include "stereo/options/command_line.h"
#include "stereo/options/within.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

constexpr std::array kNotDry{"--coats"}, kNotSketched{"--gloss"};

/// A program with options, a flag and a subcommand, and the configuration file paint.ini.
class ConfigFile : public testing::Test {
 protected:
  ConfigFile() {
    make_readable(app_);
    app_.add_option("--coats", coats_)->check(within(1, 9));
    app_.add_option("--colour", colour_);
    app_.add_option("--brush", brushes_)->allow_extra_args(false);
    app_.add_flag("--gloss", gloss_);
    app_.add_option("--dry", dry_);
    CLI::Option* const sketch = app_.add_flag("--sketch", sketch_);
    app_.get_option("--colour")->excludes(sketch);
    CLI::App* const wall = app_.add_subcommand("wall");
    wall->add_option("--coats", wall_coats_);
    wall->add_option("side", side_)->required();
    add_config_option(app_, rules());
  }

  [[nodiscard]] ConfigRules rules() const {
    return {file(), {{"--dry", "fast", kNotDry}, {"--sketch", "", kNotSketched}}};
  }
  [[nodiscard]] std::filesystem::path file() const { return folder_.path() / "paint.ini"; }
  void write(const std::string& text) const { std::ofstream(file()) << text; }

  /// The error message, or "".
  std::string parse(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "paint");
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    try {
      parse_with_config(app_, static_cast<int>(argv.size()), argv.data(), rules());
      return "";
    } catch (const CLI::ParseError& error) {
      return error.what();
    }
  }

  ScratchFolder folder_;
  CLI::App app_{"", "paint"};
  int coats_ = 1, wall_coats_ = 1;
  std::string colour_ = "white", side_, dry_;
  std::vector<std::string> brushes_;
  bool gloss_ = false, sketch_ = false;
};

TEST_F(ConfigFile, NeedNotExistByDefaultButWhereItIsNamed) {
  EXPECT_EQ(parse({"--coats", "2"}), "");
  EXPECT_EQ(coats_, 2);
  EXPECT_NE(parse({"--config", "/nowhere/x.ini"}).find("/nowhere/x.ini"), std::string::npos);
}

TEST_F(ConfigFile, SetsOptionsThatTheCommandLineDoesNotGive) {
  write("# our wall\n; old\n\n  coats = 3\r\ncolour=\"light blue \"\nbrush = a\nbrush = b=c\ngloss = true\n");
  EXPECT_EQ(parse({"--coats=4"}), "");
  EXPECT_EQ(coats_, 4);
  EXPECT_EQ(colour_, "light blue ");
  EXPECT_EQ(brushes_, (std::vector<std::string>{"a", "b=c"}));
  EXPECT_TRUE(gloss_);
}

TEST_F(ConfigFile, BrushesOfTheCommandLineReplaceThoseOfTheFile) {
  write("brush = a\ngloss = false\n");
  EXPECT_EQ(parse({"--brush", "x"}), "");
  EXPECT_EQ(brushes_, (std::vector<std::string>{"x"}));
  EXPECT_FALSE(gloss_);
}

TEST_F(ConfigFile, IsReadFromWhereConfigSaysAndNotAtAllIfThatIsEmpty) {
  write("coats = 3\n");
  std::ofstream(folder_.path() / "other.ini") << "coats = 5\n";
  EXPECT_EQ(parse({"--config", (folder_.path() / "other.ini").string()}), "");
  EXPECT_EQ(coats_, 5);
  coats_ = 1;
  EXPECT_EQ(parse({"--config", ""}), "");
  EXPECT_EQ(coats_, 1);
}

TEST_F(ConfigFile, NamesFileAndKeyOfAnUnknownKeyWithASuggestion) {
  write("coats = 3\ncolor = red\n");
  EXPECT_EQ(parse({}), file().string() + ": unknown key 'color'; did you mean colour?");
  write("zzzzzzzz = red\n");
  EXPECT_EQ(parse({}), file().string() + ": unknown key 'zzzzzzzz'");
}

TEST_F(ConfigFile, CannotAskForHelpOrForAnotherFile) {
  for (const std::string key : {"help", "config"}) {
    write(key + " = x\n");
    EXPECT_EQ(parse({}), file().string() + ": unknown key '" + key + "'");
  }
}

TEST_F(ConfigFile, NamesTheFileWhereAValueOrALineIsWrong) {
  write("coats = 12\n");
  EXPECT_EQ(parse({}), file().string() + ": --coats: '12' is not within 1 to 9");
  write("coats = many\n");
  EXPECT_TRUE(parse({}).starts_with(file().string() + ": ")) << parse({});
  write("coats = 2\n[wall]\n");
  EXPECT_EQ(parse({}), file().string() + ": line 2: '[wall]' is not KEY = VALUE");
  write("coats = 2\n");
  EXPECT_EQ(parse({"--coats", "12"}), "--coats: '12' is not within 1 to 9") << "not the file's";
}

TEST_F(ConfigFile, YieldsToOptionsThatExcludeItsOwn) {
  write("colour = red\n");
  EXPECT_EQ(parse({"--sketch"}), "");
  EXPECT_EQ(colour_, "white");
  EXPECT_TRUE(sketch_);
  write("sketch = true\n");
  sketch_ = false;
  EXPECT_EQ(parse({"--colour", "green"}), "");
  EXPECT_FALSE(sketch_);
}

TEST_F(ConfigFile, YieldsToTheOptionsAndValuesThatReplaceItsKeys) {
  write("coats = 3\ncolour = red\ngloss = true\n");
  for (const char* dry : {"--dry=fast", "--dry=slow", ""}) {
    coats_ = 1;
    EXPECT_EQ(parse(*dry == 0 ? std::vector<std::string>{} : std::vector<std::string>{dry}), "");
    EXPECT_EQ(coats_, dry == std::string("--dry=fast") ? 1 : 3) << dry;
    EXPECT_EQ(colour_, "red");
    EXPECT_TRUE(gloss_);
  }
  EXPECT_EQ(parse({"--dry", "fast"}), "");
  EXPECT_EQ(app_.count("--coats"), 0u);
  EXPECT_EQ(parse({"--sketch"}), "");
  EXPECT_EQ(app_.count("--gloss"), 0u) << "an exception without a value";
}

TEST_F(ConfigFile, GivesASubcommandTheKeysThatItHas) {
  write("coats = 3\ncolour = red\n");
  EXPECT_EQ(parse({"wall", "north"}), "");
  EXPECT_EQ(wall_coats_, 3);
  EXPECT_EQ(side_, "north");
  EXPECT_EQ(coats_, 1);
  EXPECT_EQ(colour_, "white");
}

TEST_F(ConfigFile, TakesAValueThatIsASubcommandsNameAsAValue) {
  write("coats = 3\n");
  EXPECT_EQ(parse({"--colour", "wall"}), "");
  EXPECT_EQ(colour_, "wall");
  EXPECT_EQ(coats_, 3);
  write("gloss = true\n");  // the subcommand has no such option
  EXPECT_EQ(parse({"--colour", "wall"}), "");
  EXPECT_TRUE(gloss_);
}

TEST_F(ConfigFile, DoesNotHideTheHelp) {
  write("nonsense\n");
  EXPECT_THROW(parse_with_config(app_, 2, std::array{"paint", "--help"}.data(), rules()), CLI::CallForHelp);
  EXPECT_THROW(parse_with_config(app_, 2, std::array{"paint", "-h"}.data(), rules()), CLI::CallForHelp);
}

}  // namespace
}  // namespace farshade

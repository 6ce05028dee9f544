#include "stereo/options/command_line.h"

#include <gtest/gtest.h>

#include "stereo/options/within.h"

namespace farshade {
namespace {

const std::vector<std::string> kWords{"hybrid", "remote", "delta", ""};

TEST(Suggestion, IsTheNearestWord) {
  EXPECT_EQ(suggestion("hybird", kWords), "; did you mean hybrid?");
  EXPECT_EQ(suggestion("remot", kWords), "; did you mean remote?");
  EXPECT_EQ(suggestion("dleta", kWords), "; did you mean delta?");
  EXPECT_EQ(suggestion("magic", kWords), "");
  EXPECT_EQ(suggestion("", kWords), "");
  EXPECT_EQ(suggestion(std::string(3000, 'h'), kWords), "");
}

enum class Colour : std::uint8_t { Red, Green };

struct Outcome {
  int status;
  std::string out, errors;
};

Outcome parse(CLI::App& app, const std::string& arguments) {
  std::ostringstream out, errors;
  try {
    app.parse(arguments, true);
    return {0, "", ""};
  } catch (const CLI::ParseError& error) {
    const int status = app.exit(error, out, errors);
    return {status, out.str(), errors.str()};
  }
}

TEST(Words, SetTheValueAndAreShownInsteadOfNumbers) {
  CLI::App app("", "paint");
  make_readable(app);
  Colour colour = Colour::Green;
  int coats = 2;
  add_words<Colour>(app, "--colour", colour, {{"red", Colour::Red}, {"green", Colour::Green}}, "the paint");
  app.add_option("--coats", coats, "layers")->check(within(1, 9))->capture_default_str();
  const std::string help = parse(app, "paint --help").out;
  EXPECT_NE(help.find("--colour red|green (default: green)"), std::string::npos) << help;
  EXPECT_NE(help.find("--coats NUMBER (1 to 9, default: 2)"), std::string::npos) << help;
  EXPECT_EQ(help.find('\0'), std::string::npos);
  EXPECT_EQ(colour, Colour::Green) << "without the option the value stays";
  EXPECT_EQ(parse(app, "paint --colour red").status, 0);
  EXPECT_EQ(colour, Colour::Red);
  EXPECT_EQ(parse(app, "paint --colour 1").errors,
            "paint: --colour: '1' is not one of red, green (see --help)\n");
}

TEST(Help, ShowsAFlagThatIsFalseWhenGivenAsAnyOther) {
  CLI::App app("", "paint");
  make_readable(app);
  bool drips = true;
  app.add_flag("!--no-drips", drips, "none");
  const std::string help = parse(app, "paint --help").out;
  EXPECT_NE(help.find("--no-drips  "), std::string::npos) << help;
  EXPECT_EQ(help.find("{false}"), std::string::npos) << help;
}

TEST(UnknownOptions, AreNamedWithASuggestionAlsoInSubcommands) {
  CLI::App app("", "paint");
  make_readable(app);
  std::string brush;
  app.add_subcommand("wall")->add_option("--brush", brush, "");
  EXPECT_EQ(parse(app, "paint wall --brsuh flat").errors,
            "paint: unknown option --brsuh; did you mean --brush? (see --help)\n");
  EXPECT_EQ(parse(app, "paint wal").errors,
            "paint: unexpected argument wal; did you mean wall? (see --help)\n");
}

}  // namespace
}  // namespace farshade

#include "vr_client/report/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "vr_client/report/frame_log.h"

namespace farshade {
namespace {

bool is_printed_in(const std::string& group, const std::string& name, Mode mode) {
  for (const Figure& figure : figures())
    if (figure.group() == group && figure.text.name == name)
      return (figure.printed_in >> static_cast<unsigned>(mode) & 1u) != 0;
  ADD_FAILURE() << "there is no " << group << " " << name;
  return false;
}

TEST(Figures, EachHasADefinitionAWayOfMeasuringAndAUnitUnlessItIsAPlainNumber) {
  const std::vector<FigureText> texts = figure_texts();
  EXPECT_GT(texts.size(), 50u);
  for (const FigureText& text : texts) {
    EXPECT_EQ(text.unit.empty(), text.name == "FLIP" || text.name == "SSIM") << text.name;
    EXPECT_TRUE(text.meaning.ends_with('.')) << text.name;
    EXPECT_TRUE(text.measured.ends_with('.')) << text.name;
    EXPECT_EQ((text.group + text.name + text.unit).find_first_of(",[]\"\n"), std::string::npos)
        << text.name << " is a field of CSV files and a part of their headings";
  }
}

TEST(Figures, NamesAreUniqueInTheirGroups) {
  std::set<std::string> names;
  for (const Figure& figure : figures())
    EXPECT_TRUE(names.insert(figure.group() + " " + figure.text.name).second) << figure.text.name;
  for (const RunFigure& figure : run_figures())
    EXPECT_TRUE(names.insert(figure.text.group + " " + figure.text.name).second) << figure.text.name;
}

TEST(Figures, BothEyesHaveTheSameOnes) {
  std::vector<std::string> names[2];
  for (const Figure& figure : figures())
    if (figure.side) names[index_of(*figure.side)].push_back(figure.text.name);
  EXPECT_GT(names[0].size(), 10u);
  EXPECT_EQ(names[0], names[1]);
}

TEST(Figures, AModePrintsThoseOfItsOwnWork) {
  EXPECT_TRUE(is_printed_in("client", "shadow maps", Mode::Local));
  EXPECT_FALSE(is_printed_in("client", "shadow maps", Mode::Hybrid));
  EXPECT_TRUE(is_printed_in("client", "turn", Mode::Remote));
  EXPECT_FALSE(is_printed_in("client", "turn", Mode::Full));
  EXPECT_FALSE(is_printed_in("client", "G-buffer", Mode::Remote));
  EXPECT_FALSE(is_printed_in("wire", "age", Mode::Local));
  EXPECT_TRUE(is_printed_in("left eye", "from older masks", Mode::ClientPositions));
  EXPECT_FALSE(is_printed_in("left eye", "mask error", Mode::Remote)) << "it shows no masks";
  for (const ModeName& mode : kModes) {
    EXPECT_TRUE(is_printed_in("client", "frame", mode.mode)) << mode.name;
    EXPECT_TRUE(is_printed_in("right eye", "PSNR", mode.mode)) << mode.name;
    EXPECT_EQ(is_printed_in("server", "frame", mode.mode), mode.answers != 0) << mode.name;
  }
}

TEST(Explain, KnowsEveryFigureByItsName) {
  for (const FigureText& figure : figure_texts()) {
    const Expected<std::string> text = explain(figure.group + " " + figure.name);
    ASSERT_TRUE(text) << text.error().what;
    for (const std::string& part : {figure.name, figure.unit, figure.meaning, figure.measured})
      EXPECT_NE(text->find(part), std::string::npos) << figure.name << ": " << *text;
  }
}

TEST(Explain, TakesNamesAsTheSummaryAndTheFilesWriteThem) {
  const Expected<std::string> text = explain("mask error");
  ASSERT_TRUE(text);
  EXPECT_TRUE(text->starts_with("eye mask error, %\n")) << *text;
  for (const std::string name :
       {"Mask Error", "eye mask error", "left eye mask error", "right eye mask error [%]"})
    EXPECT_EQ(explain(name).value_or(""), *text) << name;
}

TEST(Explain, TellsAllFiguresOfOneName) {
  const Expected<std::string> text = explain("frame");
  ASSERT_TRUE(text);
  EXPECT_NE(text->find("client frame, ms"), std::string::npos) << *text;
  EXPECT_NE(text->find("server frame, ms"), std::string::npos) << *text;
  EXPECT_EQ(text->find("frame of the surround"), std::string::npos) << *text;
}

TEST(Explain, ListsAllFiguresWithoutAName) {
  const Expected<std::string> text = explain("");
  ASSERT_TRUE(text);
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(*text, '\n')), figure_texts().size());
  EXPECT_NE(text->find("server traced shadow rays, rays"), std::string::npos) << *text;
}

TEST(Explain, SuggestsTheNameOfAMisspeltFigure) {
  const Expected<std::string> near = explain("mask eror"), far = explain("xyzzy");
  ASSERT_FALSE(near);
  ASSERT_FALSE(far);
  EXPECT_NE(near.error().what.find("did you mean mask error?"), std::string::npos) << near.error().what;
  EXPECT_EQ(far.error().what.find("did you mean"), std::string::npos) << far.error().what;
}

}  // namespace
}  // namespace farshade

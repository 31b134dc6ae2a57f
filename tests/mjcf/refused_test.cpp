// Wrong or unknown parts of a model are refused with file, line and name.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "assur/mjcf.hpp"
#include "mjcf/files.hpp"
#include "properties/random_count.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

struct Bad {
  std::string inside;   // of <mujoco>, from line 2 on
  std::string message;  // behind "FILE: "
};

std::string message_of(const std::filesystem::path& file, const ModelOptions& options = {}) {
  try {
    (void)import_model(file, options);
  } catch (const Error& error) {
    const std::string all = error.what(), front = file.string() + ": ";
    return all.starts_with(front) ? all.substr(front.size()) : all;
  }
  return "accepted";
}

std::string arm(const std::string& inside) {
  return "<worldbody>\n<body name='arm'>\n<joint name='hinge'/>\n" + inside + "\n</body>\n</worldbody>";
}

TEST(RefusedModels, NameTheLineAndTheElement) {
  const std::string two = arm("<body name='fore' pos='0 0 1'><joint name='elbow'/></body>");  // lines 2 to 7
  const std::vector<Bad> cases = {
      {"<worldbdy/>", "line 2, <worldbdy>: there is no such section; did you mean 'worldbody'?"},
      {"<compiler angle='grad'/>", "line 2, <compiler>: the attribute 'angle' is degree or radian, not 'grad'"},
      {"<compiler eulerseq='xyq'/>",
       "line 2, <compiler>: the attribute 'eulerseq' is three letters of x, y, z, X, Y, Z, not 'xyq'"},
      {"<compiler coordinate='global'/>",
       "line 2, <compiler>: global coordinates are not read; MuJoCo itself has given them up: save the model with "
       "local "
       "ones"},
      {"<compiler alignfree='true'/>",
       "line 2, <compiler>: alignfree=\"true\" moves frames to centres of mass, which are not read"},
      {"<compiler angel='degree'/>", "line 2, <compiler>: there is no attribute 'angel'; did you mean 'angle'?"},
      {"<default><joint axsi='0 0 1'/></default>",
       "line 2, <joint>: there is no attribute 'axsi'; did you mean 'axis'?"},
      {"<default><default><joint/></default></default>", "line 2, <default>: the attribute 'class' is missing"},
      {"<default>\n<default class='a'/>\n<default class='a'/></default>",
       "line 4, <default>: the class 'a' appears twice"},
      {"<default><jont/></default>", "line 2, <jont>: there are no defaults of this kind; did you mean 'joint'?"},
      {arm("<site name='s' class='big'/>"), "line 5, <site> 's': there is no class 'big'; there are: main"},
      {arm("<joint axis='0 0 0'/>"), "line 5, <joint>: the attribute 'axis' has no direction; its length is 0"},
      {arm("<joint limited='yes'/>"), "line 5, <joint>: the attribute 'limited' is true, false or auto, not 'yes'"},
      {arm("<joint limited='true'/>"),
       "line 5, <joint>: a limited joint needs a range of two numbers, of which the first is the smaller one"},
      {arm("<joint range='1 1'/>"),
       "line 5, <joint>: a limited joint needs a range of two numbers, of which the first is the smaller one"},
      {"<compiler autolimits='maybe'/>",
       "line 2, <compiler>: the attribute 'autolimits' is true or false, not 'maybe'"},
      {arm("<joint axis='0 0 1e'/>"), "line 5, <joint>: the attribute 'axis' has '1e', which is not a finite number"},
      {arm("<joint pos='nan 0 0'/>"), "line 5, <joint>: the attribute 'pos' has 'nan', which is not a finite number"},
      {arm("<joint axis='0 1'/>"), "line 5, <joint>: the attribute 'axis' has 2 numbers; 3 are wanted"},
      {arm("<joint ref='0 1'/>"), "line 5, <joint>: the attribute 'ref' has 2 numbers; 1 is wanted"},
      {arm("<joint type='hing'/>"),
       "line 5, <joint>: there is no joint type 'hing'; did you mean 'hinge'? There are: hinge, slide, ball, free"},
      {arm("<joint name='hinge'/>"), "line 5, <joint> 'hinge': another joint has this name"},
      {arm("<freejoint/>"), "line 5, <freejoint>: a free body has no other joint"},
      {arm("<body><freejoint/></body>"), "line 5, <freejoint>: only a body whose parent is the world can be free"},
      {arm("<frame><joint/></frame>"),
       "line 5, <joint>: joints inside a <frame> are not read; write them in the body itself"},
      {"<worldbody pos='0 0 1'/>", "line 2, <worldbody>: there is no attribute 'pos'"},
      {"<worldbody><joint/></worldbody>", "line 2, <joint>: the world has no joints"},
      {arm("<composite/>"),
       "line 5, <composite>: this element makes bodies in a way that is not read; save the model from MuJoCo, which "
       "writes them out"},
      {arm("<bodi/>"), "line 5, <bodi>: there is no such element; did you mean 'body'?"},
      {arm("<body mocap='true'/>"),
       "line 5, <body>: bodies that a program moves (mocap) are not read; give the body joints, and drive them"},
      {arm("<site quat='1 0 0 0' euler='0 0 1'/>"),
       "line 5, <site>: the orientation is given twice, by 'quat' and 'euler'"},
      {arm("<site quat='0 0 0 0'/>"), "line 5, <site>: the attribute 'quat' is 0"},
      {arm("<site>here</site>"), "line 5, <site>: there is text in this element: 'here'"},
      {arm("<site name='a' name='b'/>"), "line 5: the text is not XML: an attribute is wrong, or appears twice"},
      {two + "<equality>\n<connect body1='arn' anchor='0 0 0'/></equality>",
       "line 8, <connect>: there is no body 'arn'; did you mean 'arm'? There are: arm, fore, world"},
      {two + "<equality>\n<connect body1='arm'/></equality>", "line 8, <connect>: the attribute 'anchor' is missing"},
      {two + "<equality>\n<connect anchor='0 0 0'/></equality>", "line 8, <connect>: the attribute 'body1' is missing"},
      {two + "<equality>\n<connect site1='a' anchor='0 0 0'/></equality>",
       "line 8, <connect>: either 'site1' and 'site2' are wanted, or 'body1' with 'body2' and 'anchor'"},
      {two + "<equality>\n<connect active='no' body1='arm' anchor='0 0 0'/></equality>",
       "line 8, <connect>: the attribute 'active' is true or false, not 'no'"},
      {two + "<equality>\n<tendon/></equality>",
       "line 8, <tendon>: equalities of this kind are not read; connect, weld and joint are"},
      {two + "<equality>\n<weld body1='arm' torquescale='0'/></equality>",
       "line 8, <weld>: a weld with torquescale=\"0\" keeps a point only; write it as <connect>"},
      {two + "<equality>\n<joint joint1='elbow' joint2='hinge' polycoef='0 1 1 0 0'/></equality>",
       "line 8, <joint>: 'polycoef' has powers of the joint from the square on; only c0 + c1 joint2 is read"},
      {two + "<equality>\n<joint name='gear' joint1='elbow' joint2='hinge'/></equality>",
       "line 8, <joint> 'gear': an equality of joints is read only if one of the joints is driven; write --drive "
       "hinge=LAW or --drive elbow=LAW"},
      {two + "<actuator>\n<motor joint='elbo'/></actuator>",
       "line 8, <motor>: there is no joint 'elbo'; did you mean 'elbow'? There are: elbow, hinge"},
      {two + "<actuator>\n<moter joint='elbow'/></actuator>",
       "line 8, <moter>: there is no such actuator; did you mean 'motor'?"},
      {two + "<keyframe>\n<key name='k' qpos='0'/></keyframe>",
       "line 8, <key> 'k': the attribute 'qpos' has 1 numbers; the joints have 2"},
      {two + "<keyframe>\n<kei/></keyframe>", "line 8, <kei>: there is no such element; the only one here is key"},
      {"<worldbody>\n<body name='arm'><joint/><site name='a' pos='1 0 0'/></body>\n<site name='b' pos='3 0 0'/>"
       "</worldbody><equality>\n<connect name='far' site1='a' site2='b'/></equality>",
       "line 5, <connect> 'far': this loop cannot be closed; in the nearest posture to the start a gap of 2 m is left"},
      {"<include file='none.xml'/>",
       "line 2, <include>: the file 'none.xml' cannot be read: no such file or directory; its path is relative to the "
       "first file of the model"},
      {"<include file='../model.xml'/>",
       "line 2, <include>: the file '../model.xml' is outside the folder of the model; files are included only from "
       "there"},
      {"<include file='/etc/passwd'/>",
       "line 2, <include>: the file '/etc/passwd' is outside the folder of the model; files are included only from "
       "there"},
      {"<include file='model.xml'/>", "line 2, <include>: the file 'model.xml' is included a second time"},
      {"<include/>", "line 2, <include>: the attribute 'file' is missing"},
      {"<worldbody>", "line 2: the text is not XML: the element that begins here does not end, or another one ends"},
  };
  const test::Folder folder;
  for (const Bad& c : cases) {
    EXPECT_EQ(message_of(folder.write("model.xml", "<mujoco>\n" + c.inside + "\n</mujoco>\n")), c.message) << c.inside;
  }
}

TEST(RefusedModels, WrongOptionsListTheChoices) {
  const test::Folder folder;
  const std::string file = folder.write("model.xml", "<mujoco>\n" + arm("") +
                                                         "<actuator><motor joint='hinge'/></actuator>"
                                                         "<keyframe><key name='home'/></keyframe></mujoco>");
  const std::vector<std::pair<ModelOptions, std::string>> cases = {
      {{"hom", {}}, "--key: there is no keyframe 'hom'; did you mean 'home'? There are: home"},
      {{"", {{"hing", "0"}}}, "--drive hing: there is no such hinge or slide; did you mean 'hinge'? There are: hinge"},
      {{"", {{"hinge", "fast"}}},
       "--drive hinge: 'fast' is not a law; write coefficients of a polynomial of t, \"0,6.28\", a law of the scene "
       "format, "
       "{\"constant\": 0}, or free"},
      {{"", {{"hinge", "{\"constant\""}}},
       "--drive hinge: line 1, column 12: not JSON: unexpected end of input; expected ':'"},
      {{"", {{"hinge", "0"}, {"hinge", "1"}}}, "--drive hinge: the joint is named twice"},
  };
  for (const auto& [options, message] : cases) EXPECT_EQ(message_of(file, options), message);
}

TEST(RefusedModels, AreBoundedInSizeAndDepth) {
  const test::Folder folder;
  std::string deep, end;
  for (int i = 0; i < 120; ++i) deep += "<body>", end += "</body>";
  EXPECT_EQ(message_of(folder.write("model.xml", "<mujoco><worldbody>\n" + deep + end + "</worldbody></mujoco>")),
            "line 2: elements are nested more than 90 levels deep, the limit");
  EXPECT_EQ(message_of(folder.write("model.xml", "<mujoco>" + std::string(16'000'001, ' ') + "</mujoco>")),
            "the model cannot be read: it is larger than 16 MB, the limit");
  // Each file is below the limit, but not both together.
  const std::string half(9'000'000, ' ');
  folder.write("part.xml", "<mujocoinclude>" + half + "</mujocoinclude>");
  EXPECT_EQ(message_of(folder.write("model.xml", "<mujoco>" + half + "<include file='part.xml'/></mujoco>")),
            folder.path("part.xml") + ": the files of the model have more than 16 MB, the limit");
  // The limit of depth holds over several files.
  folder.write("part.xml", "<mujocoinclude>" + deep.substr(0, 6 * 60) + end.substr(0, 7 * 60) + "</mujocoinclude>");
  EXPECT_EQ(message_of(folder.write("model.xml", "<mujoco><worldbody>" + deep.substr(0, 6 * 60) +
                                                     "<include file='part.xml'/>" + end.substr(0, 7 * 60) +
                                                     "</worldbody></mujoco>")),
            folder.path("part.xml") + ": line 1: elements are nested more than 90 levels deep, the limit");
  // With each release of tinyxml2, whose own limits differ.
  for (const int count : {88, 89, 97, 99, 400, 600}) {  // and <mujoco>, <worldbody>
    std::string text;
    for (int i = 0; i < count; ++i) text += "<body>";
    for (int i = 0; i < count; ++i) text += "</body>";
    const std::string said =
        message_of(folder.write("model.xml", "<mujoco><worldbody>" + text + "</worldbody></mujoco>"));
    EXPECT_EQ(said.find("elements are nested more than 90 levels deep") != said.npos, count > 88) << count << said;
  }
}

// Nesting of defaults and of includes, numbers of elements, and entities.
TEST(RefusedModels, AreBoundedInTheirExpandedSize) {
  const test::Folder folder;
  const auto refusal = [&](const std::string& inside) {
    return message_of(folder.write("model.xml", "<mujoco>\n" + inside + "</mujoco>"));
  };
  std::string deep, end;
  for (int i = 0; i < 120; ++i) deep += "<default class='c" + std::to_string(i) + "'>", end += "</default>";
  EXPECT_EQ(refusal(deep + end), "line 2: elements are nested more than 90 levels deep, the limit");
  for (int i = 0; i < 9; ++i) {
    folder.write("part" + std::to_string(i) + ".xml",
                 "<mujocoinclude><include file='part" + std::to_string(i + 1) + ".xml'/></mujocoinclude>");
  }
  EXPECT_EQ(refusal("<include file='part0.xml'/>"),
            folder.path("part7.xml") + ": line 1, <include>: files include each other more than 8 times, the limit");
  std::string many;
  for (int i = 0; i < 500'000; ++i) many += "<geom/>";
  folder.write("part.xml", "<mujocoinclude><body>" + many + "</body></mujocoinclude>");
  EXPECT_EQ(refusal("<worldbody>" + many + "<include file='part.xml'/></worldbody>"),
            folder.path("part.xml") + ": the files of the model have more than 1,000,000 elements, the limit");
  EXPECT_EQ(message_of(folder.write("model.xml",
                                    "<!DOCTYPE m [<!ENTITY a 'joint'><!ENTITY b '&a;&a;&a;&a;'>]>\n<mujoco><worldbody>"
                                    "<body><joint type='&b;'/></body></worldbody></mujoco>")),
            "line 2, <joint>: there is no joint type '&b;'; there are: hinge, slide, ball, free");
}

TEST(RefusedModels, NumbersAreFiniteAndNotTooLarge) {
  const test::Folder folder;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"<joint pos='inf 0 0'/>", "<joint>: the attribute 'pos' has 'inf', which is not a finite number"},
      {"<joint ref='1e999'/>", "<joint>: the attribute 'ref' has '1e999', which is not a finite number"},
      {"<joint axis='0 0 1e200'/>", "<joint>: the attribute 'axis' has '1e200'; the limit is 1e100"},
      {"<joint axis='0 0 1e-200'/>", "<joint>: the attribute 'axis' has no direction; its length is 0"},
      {"<site quat='1e-300 0 0 0'/>", "<site>: the attribute 'quat' is 0"},
      {"<site pos='-1e101 0 0'/>", "<site>: the attribute 'pos' has '-1e101'; the limit is 1e100"}};
  for (const auto& [inside, message] : cases) {
    EXPECT_EQ(message_of(folder.write("model.xml", "<mujoco>\n" + arm(inside) + "</mujoco>")), "line 5, " + message);
  }
  EXPECT_EQ(message_of(
                folder.write("model.xml", "<mujoco>\n" + arm("<joint pos='1e99 0 0' axis='1 1e90 0'/>") + "</mujoco>")),
            "accepted");
}

// Work grows with the size of a model: many defaults of one class, and long chains of joints that move together.
TEST(RefusedModels, LongListsAreReadInProportionToTheirLength) {
  const test::Folder folder;
  const int many = test::random_count(20'000);
  std::string defaults, bodies, equalities;
  for (int i = 0; i < many; ++i) {
    const std::string k = std::to_string(i);
    defaults += "<joint axis='0 0 1'/>";
    bodies += "<body><joint name='j" + k + "'/></body>";
    if (i > 0) equalities = "<joint joint1='j" + k + "' joint2='j" + std::to_string(i - 1) + "'/>" + equalities;
  }
  const ImportedModel model =
      import_model(folder.write("model.xml", "<mujoco><default>" + defaults + "</default><worldbody>" + bodies +
                                                 "</worldbody><equality>" + equalities + "</equality></mujoco>"),
                   {"", {{"j0", "0,1"}}, {}});
  EXPECT_EQ(model.drivers.size(), static_cast<std::size_t>(many));
}

TEST(RefusedModels, IncludeFilesOfOtherFormats) {
  const test::Folder folder;
  EXPECT_EQ(message_of(folder.write("model.xml", "<robot/>")),
            "line 1: a model of MuJoCo begins with <mujoco>, not with <robot>");
  EXPECT_EQ(message_of(folder.path("none.xml")), "the model cannot be read: no such file or directory");
  EXPECT_EQ(message_of(folder.write("model.xml", "")), "the text is not XML: there is no element");
}

// Bytes that are changed at random end with a scene or an Error, never otherwise.
TEST(RefusedModels, DamagedFilesEndWithAnError) {
  const test::Folder folder;
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  const int each = test::random_count(150);
  int accepted = 0, refused = 0;
  for (const std::string name : {"five_bar", "delta", "stewart"}) {
    std::ifstream in(ASSUR_SOURCE_DIR "/scenes/mjcf/" + name + ".xml");
    std::stringstream text;
    text << in.rdbuf();
    for (int i = 0; i < each; ++i) {
      std::string bad = text.str();
      for (std::size_t k = 0; k <= below(4); ++k) {
        const std::size_t at = below(bad.size()), length = below(12);
        const std::string other = bad.substr(below(bad.size()), length);
        if (below(2) == 0) {
          bad.replace(at, other.size(), other);
        } else {
          bad[at] = static_cast<char>(below(256));
        }
      }
      try {
        (void)import_model(folder.write("model.xml", bad));
        ++accepted;
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()), "");
        ++refused;
      }
    }
  }
  EXPECT_GT(accepted, each / 15);
  EXPECT_GT(refused, each / 2);
}

}  // namespace
}  // namespace assur

/// Which columns of a file hold what: the layouts that programs of the field write are read, or refused by
/// name.
#include <gtest/gtest.h>

#include <algorithm>

#include "stereo/head/reader.h"
#include "tests/unit/head/worn_head.h"

namespace farshade {
namespace {

void expect_worn(const Expected<HeadRecording>& recording) {
  ASSERT_TRUE(recording) << recording.error().what;
  ASSERT_EQ(recording->samples.size(), static_cast<std::size_t>(kWornSamples));
  EXPECT_EQ(recording->doubt, "") << recording->read_as;
  EXPECT_NEAR(seconds_of(recording->end() - recording->start()), (kWornSamples - 1) / kWornRate_hz, 1e-3);
  for (const int i : {0, 50, 143}) {
    const Rigid<Recorded, Head>& got = recording->samples[static_cast<std::size_t>(i)].recorded_from_head;
    EXPECT_LT(angle_between_rad(got.rotation, worn_head(i).rotation), 1e-5)
        << i << ": " << recording->read_as;
    EXPECT_LT(glm::length(got.translation - worn_head(i).translation), 1e-5)
        << i << ": " << recording->read_as;
  }
}

void expect_refused(const std::string& text, const std::string& named) {
  const auto recording = parse_head_recording(text, "t.csv");
  ASSERT_FALSE(recording) << named << ": " << recording->read_as;
  EXPECT_NE(recording.error().what.find(named), std::string::npos) << recording.error().what;
}

struct Written {
  const char* by;
  std::string header;
  Text rows;
};

TEST(HeadLayout, ReadsWhatProgramsWrite) {
  const double ns = 1.7e18, step_ns = 13'888'888;
  for (const auto& [by, header, rows] : {
           Written{"EuRoC with velocity and biases", "", {ns, step_ns, ',', true, {}, ",0,0,0,0,0,0,0,0,0"}},
           Written{"Kimera",
                   "#timestamp_kf,x,y,z,qw,qx,qy,qz,vx,vy,vz\n",
                   {ns, step_ns, ',', true, {}, ",9,9,9"}},
           Written{"OKVIS2",
                   "timestamp, p_WS_W_x, p_WS_W_y, p_WS_W_z, q_WS_x, q_WS_y, q_WS_z, q_WS_w, v_WS_W_x\n",
                   {ns, step_ns, ',', false, {}, ",9"}},
           Written{"VINS-Fusion", "", {ns, step_ns, ',', true, {}, ",9,9,9,"}},
           Written{"OpenVINS",
                   "# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12\n",
                   {1.7e9, 1 / 72.0, ' ', false, {}, " 9 9"}},
           Written{"ORB-SLAM3, SaveTrajectoryEuRoC", "", {ns, step_ns, ' ', false}},
           Written{"ADVIO", "", {0, 1 / 72.0, ',', true}},
           Written{"rostopic echo -p",
                   "%time,field.pose.position.x,field.pose.position.y,field.pose.position.z,field.pose."
                   "orientation.x,"
                   "field.pose.orientation.y,field.pose.orientation.z,field.pose.orientation.w\n",
                   {ns, step_ns, ',', false}},
           Written{"Aria closed_loop_trajectory",
                   "tracking_timestamp_us,tx_world_device,ty_world_device,tz_world_device,qx_world_device,"
                   "qy_world_device,qz_world_device,qw_world_device,device_linear_velocity_x_device,gravity_"
                   "x_world\n",
                   {5e6, 13'889, ',', false, {}, ",9,9"}},
           Written{"AirSim",
                   "TimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n",
                   {1.7e12, 13.888, '\t', true, {}, "\timg.png"}},
           Written{"a Unity logger",
                   "time,posX,posY,posZ,rotX,rotY,rotZ,rotW,lefthand_pos_x\n",
                   {3, 1 / 72.0, ',', false, {}, ",9"}},
           Written{"another Unity logger",
                   "\"timeStamp\",\"HeadPositionX\",\"HeadPositionY\",\"HeadPositionZ\",\"HeadRotationX\","
                   "\"HeadRotationY\",\"HeadRotationZ\",\"HeadRotationW\"\n",
                   {3, 1 / 72.0, ',', false}},
       }) {
    SCOPED_TRACE(by);
    expect_worn(parse_head_recording(header + text_of(rows), "t.csv"));
  }
}

TEST(HeadLayout, ReadsLineEndsOfOldMacs) {
  std::string text = text_of({.separator = ' ', .scalar_first = false});
  std::ranges::replace(text, '\n', '\r');
  expect_worn(parse_head_recording(text, "t.txt"));
}

TEST(HeadLayout, TakesTheColumnsOfTheHeadAmongOthers) {
  std::string text =
      "frame,lefthand_pos_x,lefthand_pos_y,lefthand_pos_z,time_ms,valid,head_pos_x,head_pos_y,head_pos_z,"
      "head_rot_w,head_rot_x,head_rot_y,"
      "head_rot_z\n";
  for (int i = 0; i < 20; ++i)
    text += fmt::format("{},7,7,7,{},{},1,2,3,1,0,0,0\n", i, 14 * i, i == 3 ? "false" : "1");
  const auto recording = parse_head_recording(text, "t.csv");
  ASSERT_TRUE(recording) << recording.error().what;
  EXPECT_EQ(recording->samples.size(), 19u);
  EXPECT_EQ(recording->samples[5].recorded_from_head.translation, glm::dvec3(1, 2, 3));
  EXPECT_NE(recording->doubt.find("t.csv:5: tracking was lost"), std::string::npos) << recording->doubt;
}

TEST(HeadLayout, TakesNoOtherVectorForPositionOrRotation) {
  const std::string rotation = ",qw,qx,qy,qz\n", rows = text_of({});
  for (const char* other : {"acc", "gyro", "v", "dir", "euler", "forward", "scale"})
    expect_refused(fmt::format("time,{0}_x,{0}_y,{0}_z", other) + rotation + rows, "t.csv:1: ");
  for (const char* position : {"x,y,z", "x [m],y [m],z [m]", "x_m,y_m,z_m"})
    expect_worn(parse_head_recording(std::string("time,") + position + rotation + rows, "t.csv"));
  // The position has a word, wherever it stands.
  std::string text = "x,y,z,rot_x,rot_y,rot_z,quat_w,quat_x,quat_y,quat_z,time,pos_x,pos_y,pos_z\n";
  for (int i = 0; i < 9; ++i) text += fmt::format("7,8,9,0.1,0.2,0.3,1,0,0,0,{},1,2,3\n", i / 64.0);
  const auto recording = parse_head_recording(text, "t.csv");
  ASSERT_TRUE(recording) << recording.error().what;
  EXPECT_EQ(recording->samples[5].recorded_from_head.translation, glm::dvec3(1, 2, 3));
  EXPECT_EQ(recording->samples[5].recorded_from_head.rotation, glm::dquat(1, 0, 0, 0));
}

TEST(HeadLayout, TakesTheUnitOfPositionsFromTheirNames) {
  const auto in = [](double units_a_metre, char separator) {
    return text_of({.separator = separator, .axes = {.units_a_metre = units_a_metre}});
  };
  for (const auto& [names, units] : std::vector<std::pair<std::string, double>>{
           {"time,x [cm],y [cm],z [cm],qw,qx,qy,qz", 100},
           {"#time [s],p_RS_R_x [mm],p_RS_R_y [mm],p_RS_R_z [mm],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []",
            1000},
           {"time,tx(cm),ty(cm),tz(cm),qw,qx,qy,qz", 100},
           {"time,pos_x_mm,pos_y_mm,pos_z_mm,qw,qx,qy,qz", 1000},
           {"time,PositionX_Centimeters,PositionY_Centimeters,PositionZ_Centimeters,qw,qx,qy,qz", 100},
           {"time,pos_x_metres,pos_y_metres,pos_z_metres,qw,qx,qy,qz", 1},
           {"# time [s] tx [mm] ty [mm] tz [mm] qw [] qx [] qy [] qz []", 1000},
           {"time (s) x (cm) y (cm) z (cm) qw qx qy qz", 100}}) {
    SCOPED_TRACE(names);
    const std::string text = names + "\n" + in(units, names.find(',') == names.npos ? ' ' : ',');
    const auto recording = parse_head_recording(text, "t.csv");
    expect_worn(recording);
    if (!recording) continue;
    EXPECT_TRUE(recording->read_as.ends_with(
        units == 1 ? ", positions in m (stated)" : fmt::format(", {:g} units a metre (stated)", units)))
        << recording->read_as;
    const auto given = parse_head_recording(text, "t.csv", {.units_a_metre = 2 * units});
    ASSERT_TRUE(given) << given.error().what;
    EXPECT_NEAR(given->samples[0].recorded_from_head.translation.y, 0.8, 1e-5) << "--trace-scale is stronger";
    EXPECT_EQ(given->read_as.find("metre (stated)"), std::string::npos);
  }
  Axes unreal = parse_axes("unreal").value();
  unreal.units_a_metre = 1;
  expect_worn(parse_head_recording("time,x [m],y [m],z [m],qw,qx,qy,qz\n" + text_of({.axes = unreal}),
                                   "t.csv", {.axes = parse_axes("unreal").value()}));
}

TEST(HeadLayout, RefusesACommentWhoseNamesItOnlyPartlyKnows) {
  expect_refused("#timestamp,x,y,z,qi,qj,qk,qr\n" + text_of({.scalar_first = false}),
                 "t.csv:1: no number and no column names of a head recording: no column of qw, qx, qy, qz");
  expect_refused("# timestamp tx ty tz qi qj qk qr\n" + text_of({.separator = ' ', .scalar_first = false}),
                 "no column of qw, qx, qy, qz");
  expect_refused("#time,east,north,up,qi,qj,qk,qr\n" + text_of({}), "no column of x, y, z, qw");
  expect_worn(parse_head_recording("# t is the time in seconds since start\n" + text_of({}), "t.csv"));
}

TEST(HeadLayout, SkipsWordsThatIntroduceTheNames) {
  const std::string xyzw = text_of({.separator = ' ', .scalar_first = false}),
                    wxyz = text_of({.separator = ' '});
  expect_worn(parse_head_recording("# format: timestamp tx ty tz qx qy qz qw\n" + xyzw, "t.txt"));
  expect_worn(parse_head_recording("# timestamp [s] tx ty tz qx qy qz qw\n" + xyzw, "t.txt"));
  expect_worn(parse_head_recording("# format: timestamp tx ty tz qw qx qy qz\n" + wxyz, "t.txt"));
  const auto in_cm =
      parse_head_recording("# format: timestamp [s] tx [cm] ty [cm] tz [cm] qx qy qz qw\n" + xyzw, "t.txt");
  ASSERT_TRUE(in_cm) << in_cm.error().what;
  EXPECT_NEAR(in_cm->samples[0].recorded_from_head.translation.y * 100, worn_head(0).translation.y, 1e-5);
  expect_refused("# format: timestamp tx ty tz qx qy qz qw vx vy\n" +
                     text_of({.separator = ' ', .scalar_first = false, .more = " 9 9"}),
                 "row has 10 columns");
}

TEST(HeadLayout, TakesStampsInNanosecondsAlone) {
  for (const char* stamp : {"time_nsec", "timestamp [nsec]"})
    expect_worn(parse_head_recording(
        stamp + std::string(",x,y,z,qw,qx,qy,qz\n") + text_of({.first = 1.7e18, .step = 13'888'888}),
        "t.csv"));
}

TEST(HeadLayout, NeedsOnlyTheColumnsThatItUses) {
  for (const char* start : {"", "#"})
    for (const char* more : {",", ",a note", ""})
      expect_worn(parse_head_recording(start + std::string("time,x,y,z,qx,qy,qz,qw,note\n") +
                                           text_of({.scalar_first = false, .more = more}),
                                       "t.csv"));
}

TEST(HeadLayout, RefusesByName) {
  const auto rows = [](const std::string& row) { return row + "\n" + row + "\n" + row + "\n"; };
  expect_refused(rows("1 0 0 0 0 1 0 0 0 0 1 0"),
                 "t.csv:1: rows of 12 columns are no head recording, but perhaps KITTI");
  expect_refused(rows("9, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0"), "ARKit-Data-Logger");
  expect_refused(rows("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), "4x4 matrices without time stamps");
  expect_refused(rows("9,1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"), "time stamps and 4x4 matrices");
  expect_refused(rows("1,2,3,1,0,0,0"), "without time stamps");
  expect_refused(rows("1,2,3,4,5,6,7,8,9"), "row has 9 columns");
  expect_refused("time,x,y,z,roll,pitch,yaw\n" + rows("1,2,3,4,5,6,7"), "Euler angles");
  expect_refused("time,x,y,z,qx,qy,qz\n" + rows("1,2,3,4,5,6,7"),
                 "t.csv:1: no number and no column names of a head recording: no column of qw");
  expect_refused("sec,nanosec,x,y,z,qx,qy,qz,qw\n" + rows("1,2,3,4,5,0,0,0,1"), "join them in one column");
  expect_refused("stamp.nsec,stamp.sec,x,y,z,qx,qy,qz,qw\n" + rows("1,2,3,4,5,0,0,0,1"),
                 "join them in one column");
  expect_refused("time,x,y,z,qx,qw,qy,qz\n" + rows("1,2,3,4,0,1,0,0"), "columns should have the order");
  expect_refused(rows("1,0 0,0 0,0 0,0 0,0 0,0 0,0 1,0"), "t.csv:1: decimals are written with a comma");
  expect_refused("{\"frames\": []}", "JSON");
  expect_refused(std::string("\xFF\xFE"
                             "1\0",
                             4),
                 "UTF-16");
  expect_refused("#ROSBAG V2.0\n", "ROS bag");
}

}  // namespace
}  // namespace farshade

// The report of shade.comp: what each pixel was shaded with, laid out as shade_data.h says. Without REPORT all
// functions are empty.

#ifdef REPORT
layout(std430, set = REPORT_SET, binding = 0) writeonly buffer Report { uint report[]; };
const bool kReport = true;

const uint kNoRecord = ~0u;  // nothing is written to it

// The first word of a pixel's record.
uint report_record(ivec2 pixel, bool wanted) {
  vec4 size = frame.eye[shown_eye].size_px;
  return !wanted ? kNoRecord : ((shown_eye * uint(size.y) + uint(pixel.y)) * uint(size.x) + uint(pixel.x)) * FARSHADE_REPORT_WORDS(kLights);
}

void report_uncovered(uint record) {
  if (record == kNoRecord) return;
  report[record + FARSHADE_REPORT_SOURCE] = FARSHADE_SOURCE_UNCOVERED;
  for (uint word = FARSHADE_REPORT_SOURCE + 1; word < FARSHADE_REPORT_WORDS(kLights); ++word)
    report[record + word] = 0u;
}

void report_plane(uint record, uint plane, uint unknown, uint stale) {
  if (record == kNoRecord) return;
  uint used = kLights >= plane * 32 + 32 ? ~0u : (1u << (kLights % 32)) - 1u;
  report[record + FARSHADE_REPORT_UNKNOWN(kLights) + plane] = unknown & used;
  report[record + FARSHADE_REPORT_STALE(kLights) + plane] = stale & used;
}

void report_visibility(uint record, uint group, Visibility8 k) {
  if (record == kNoRecord) return;
  report[record + FARSHADE_REPORT_VISIBILITY + group * 2] = packUnorm4x8(k.low);
  if (group * 2 + 1 < kQuads) report[record + FARSHADE_REPORT_VISIBILITY + group * 2 + 1] = packUnorm4x8(k.high);
}

void report_source(uint record, bool known, bool by_rays, uint source, Sample taken, uint shining) {
  if (record == kNoRecord) return;
  uint shown_with = by_rays ? FARSHADE_SOURCE_RAYS : FARSHADE_SOURCE_UNKNOWN;
  if (known) shown_with = source + (taken.beside ? FARSHADE_NEIGHBOUR : 0u);
  report[record + FARSHADE_REPORT_SOURCE] = shown_with | shining << 16;
  report[record + FARSHADE_REPORT_X] = floatBitsToUint(taken.at.x);
  report[record + FARSHADE_REPORT_Y] = floatBitsToUint(taken.at.y);
}
#else
const bool kReport = false;
const uint kNoRecord = ~0u;
uint report_record(ivec2 pixel, bool wanted) { return kNoRecord; }
void report_uncovered(uint record) {}
void report_plane(uint record, uint plane, uint unknown, uint stale) {}
void report_visibility(uint record, uint group, Visibility8 k) {}
void report_source(uint record, bool known, bool by_rays, uint source, Sample taken, uint shining) {}
#endif

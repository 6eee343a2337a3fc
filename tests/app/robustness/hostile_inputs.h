// One small input of every kind that Firn reads, and text that does harm where it is not encoded.
#pragma once

#include <string>
#include <vector>

namespace firn::cli::hostile {

// Names and references of all kinds; 4 ms of two cubes on a floor.
inline constexpr const char* rich_case = R"([case]
name = "rich"
duration = "4 ms"

[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[materials.plastic]
young_modulus = "2 GPa"

[interactions.ice-ice]
static_friction = 0.1
dynamic_friction = 0.1
restitution = 0.3
[interactions.ice-plastic]
static_friction = 0.3
dynamic_friction = 0.3
restitution = 0.3

[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
rounding = "0.5 mm"

[[particles]]
shape = "cube"
position = "0 0 0.0099 m"
tag = 1
[[particles]]
shape = "cube"
position = "0 0 0.0302 m"

[[motion_frames]]
name = "arm"
motions = [{ kind = "translation", velocity = "1 0 0 mm/s" }]

[[boundaries]]
name = "floor"
material = "plastic"
kind = "plane"
point = "0 0 0 m"
normal = [0, 0, 1]
[[boundaries]]
name = "panel"
material = "plastic"
kind = "box"
position = "0.03 0 0.02 m"
size = "20 20 20 mm"
motion_frame = "arm"

[[sensors]]
name = "half way"
point = "0 0 0.5 m"
normal = [0, 0, -1]
[[outlets]]
name = "away"
point = "0 0 -0.5 m"
normal = [0, 0, -1]

[[stages]]
name = "settle"
max_duration = "2 ms"
[[stages]]
name = "hold"
max_duration = "2 ms"

[[measure]]
kind = "load"
name = "press"
boundary = "floor"
stage = "hold"

[[bonds]]
name = "bridge"
pairs = [[0, 1]]
height_direction = [0, 1, 0]
width = "4 mm"
height = "4 mm"
length = "1 mm"
young_modulus = "1 MPa"
poisson_ratio = 0.3
tensile_strength = "0.7 MPa"
shear_strength = "0.7 MPa"

[statistics]
[statistics.events]
threshold = "0 N"
[statistics.boundary_maps]
boundaries = ["panel"]
[statistics.energy_spectrum]
lowest = "1e-9 J"

[output]
frame_interval = "1 ms"
)";

inline constexpr const char* sweep_file = R"([sweep]
name = "boxes"
case = "case.toml"
responses = ["present_mass"]
[[vary]]
name = "density"
keys = ["materials.ice.density"]
values = ["900 kg/m^3", "1000 kg/m^3"]
)";

inline constexpr const char* optimization_file = R"([optimization]
name = "heavy boxes"
case = "case.toml"
maximize = "present_mass"
runs = 12
replicates_per_design = 2
confirmation_replicates = 2

[[parameters]]
name = "rho"
keys = ["materials.ice.density"]
min = "800 kg/m^3"
max = "1000 kg/m^3"

[[limits]]
response = "present_mass"
above = "0.016 kg"
probability = 0.2

[[compare]]
name = "as it was"
values = { rho = "900 kg/m^3" }
)";

inline constexpr const char* study_file = R"([study]
name = "study"
case = "case.toml"

[budget]
center_replicates = 3
design_points = 4
replicates_per_point = 1
refine_rounds = 0
refine_points = 1
confirmation_replicates = 2

[[parameters]]
name = "rho"
keys = ["materials.ice.density"]
min = "800 kg/m^3"
max = "1000 kg/m^3"

[[targets]]
response = "present_mass"
value = "0.0145 kg"
uncertainty = "0.0003 kg"

[[compare]]
name = "paper"
values = { rho = "900 kg/m^3" }
[[numerics]]
name = "finer"
set = { "case.steps_per_loading" = 20 }
)";

inline constexpr const char* suite_file = R"([suite]
name = "suite"
title = "All of it"
note = "a note"
seeds = 2
[[parameter_sets]]
name = "as it is"
note = "nothing changed"
[[experiments]]
name = "fall"
case = "case.toml"
[[experiments.variants]]
name = "heavier"
set = { "materials.ice.density" = "1833.4 kg/m^3" }
seeds = 1
[[comparisons]]
name = "mass"
title = "The mass"
note = "of both"
kind = "value"
experiment = "fall"
measurement = "mass.toml"
[[comparisons]]
name = "claims"
kind = "criteria"
experiment = "fall"
measurement = "claims.toml"
)";

inline constexpr const char* mass_file = R"(name = "mass of two boxes"
response = "present_mass"
values = ["0.0146 kg", "0.0147 kg", "0.0148 kg"]
status = "measured"
source = "a balance"
)";

inline constexpr const char* claims_file = R"(name = "what was seen"
status = "qualitative"
statement = "both stay"
source = "a notebook"
[[criteria]]
statement = "both stay"
lhs = "present_count"
rhs = "1.5"
rationale = "they are two"
)";

inline constexpr const char* record_file =
    R"({"format": "firn material records", "format_version": 1,
"records": [{"name": "mine", "title": "Measured by tilting", "materials": ["ice", "plastic"],
  "kind": "assumed",
  "parameters": [{"name": "friction", "keys": ["interactions.ice-plastic.static_friction",
    "interactions.ice-plastic.dynamic_friction"], "value": 0.1, "unit": "1", "uncertainty": 0.02}],
  "scope": [{"name": "temperature", "statement": "-10 C"}],
  "provenance": {"author": "me", "date": "2026-11-21", "source": "notebook 3, page 12"}}]})";

// Printable text without slashes, as any name may be. $CANARY is a file that must never appear.
inline std::vector<std::string> printable_names() {
  return {R"(a"b'c`touch $CANARY`$(touch $CANARY))",
          R"('.system("touch $CANARY").'@GPVAL_PWD %d %s{x}_^~&)",
          R"(\".system(\"touch $CANARY\").\" \n!touch $CANARY\n#)",
          R"("><img src=x onerror=alert(1)><script>alert(2))",
          R"(' onmouseover='alert(1)' ]]>&lt;script&gt;<!--)",
          R"(=cmd|' C'!A0)",
          R"(@SUM(1+1)*cmd|' C'!A0,"x";=1+1)",
          R"(+1+cmd|' C'!A0)",
          R"(```<b>|[x](y)*_)",
          R"(<touch $CANARY)",
          R"(|touch $CANARY)",
          "GröÃe ± µ \xf0\x9f\x98\x80 name"};
}

// The same, and text that no name may have.
inline std::vector<std::string> all_texts() {
  std::vector<std::string> texts = printable_names();
  for (const char* text : {"x\nsystem(\"touch $CANARY\")\n#", "x\r\nsystem(\"touch $CANARY\")",
                           "\x1b[2J\x1b]0;title\x07", "a\rb", "\t=1+1", "x\xe2\x80\xaey",
                           "\xef\xbb\xbf"
                           "bom",
                           "bad \xff\xfe utf8",
                           "\xc2\x9b"
                           "31m",
                           "</script><script>alert(1)</script>", "../../escaped", ".", "..", "",
                           "-rf", "/absolute", "\x7f\x08\x08", "END\n!touch $CANARY"})
    texts.emplace_back(text);
  texts.emplace_back("nul\0nul", 7);
  texts.emplace_back(100000, 'x');
  return texts;
}

// Checks pages, pictures, tables: arguments are files, their names say what they are; a page
// PAGE.html is compared with PAGE.html.benign. Prints one line for each fault.
inline constexpr const char* checker = R"py(
import csv, html.parser, re, sys, xml.etree.ElementTree as tree
class Page(html.parser.HTMLParser):
    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.tags, self.scripts, self.script, self.faults = set(), [], None, []
    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        for name, value in attributes:
            if name.startswith('on') or name == 'srcdoc' or (value or '').strip().lower().startswith('javascript:'):
                self.faults.append('attribute %s of %s' % (name, tag))
        if tag == 'script' and dict(attributes).get('type') != 'text/plain':
            self.script = ''
    def handle_data(self, data):
        if self.script is not None: self.script += data
    def handle_endtag(self, tag):
        if tag == 'script' and self.script is not None:
            self.scripts.append(self.script); self.script = None
def parsed(name):
    page = Page(); page.feed(open(name, encoding='utf-8', errors='strict').read()); page.close(); return page
def check(name):
    if name.endswith('.html'):
        page, benign = parsed(name), parsed(name + '.benign')
        yield from page.faults
        if page.scripts != benign.scripts: yield 'other scripts'
        # What only some plots have.
        extra = page.tags - benign.tags - {'tspan', 'use', 'path', 'line', 'rect', 'circle', 'polygon', 'details', 'small', 'p'}
        if extra: yield 'tags %s' % sorted(extra)
    elif name.endswith('.svg'):
        for element in tree.parse(name).iter():
            if element.tag.split('}')[-1] in ('script', 'foreignObject', 'img'): yield element.tag
            for attribute in element.attrib:
                if attribute.startswith('on'): yield attribute
    elif name.endswith('.csv'):
        rows = list(csv.reader(open(name, encoding='utf-8', newline=''), strict=True))
        for row in rows:
            if len(row) != len(rows[0]): yield 'row of %d fields, not %d: %r' % (len(row), len(rows[0]), row)
            for field in row:
                if field[:1] in ('=', '+', '-', '@', '\t', '\r') :
                    try: float(field)
                    except ValueError: yield 'formula %r' % field
    elif name.endswith('.md'):
        text = open(name, encoding='utf-8').read()
        if re.search('<[a-z!/]', re.sub('^(`{3,})\n.*?^\\1$', '', text, flags=re.M | re.S)): yield 'markup'
for name in sys.argv[1:]:
    for fault in check(name): print('%s: %s' % (name, fault))
)py";

}  // namespace firn::cli::hostile

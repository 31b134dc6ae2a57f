# Comments of the headers as Doxygen reads them: `//` in front of a declaration becomes `///`, and `//` behind one `///<`,
# with the lines that continue it in the same column. What stands behind the `{` of a type describes the type, and the
# comment at the top of a file the file. In pages, links lose their anchors, which Doxygen 1.9.4 does not know.
FILENAME !~ /\.hpp$/ { gsub(/\.md#[a-z0-9-]+\)/, ".md)"); print; next }
NR == 1 && /^\/\// { print "/// @file" }
/^ *\/\/ ----/ { print ""; column = 0; next }  # a heading between declarations
{
  sub(/ *\/\/ (NOLINT|IWYU pragma).*/, "")
  at = match($0, /\/\/ /)
  code = substr($0, 1, at - 1)
  text = substr($0, at + 3)
  if (at == 0) {
    column = 0
    print
  } else if (code ~ /^ *(struct|class|enum class) [^;]*\{ *$/) {
    indent = substr($0, 1, match($0, /[^ ]/) - 1)
    print indent "/// " text
    print code
    column = 0
  } else if (code ~ /^ *$/ && at != column) {
    column = 0
    print code "/// " text
  } else {
    column = at
    # Of several members declared together, Doxygen documents the last: each gets the comment.
    if (code ~ /^ *[A-Za-z_:0-9]+ [a-z_]+( = [A-Za-z_:0-9]+)?(, [a-z_]+( = [A-Za-z_:0-9]+)?)+; *$/) {
      each = text
      gsub(/&/, "\\\\&", each)
      gsub(/, /, ", /**< " each " */ ", code)
    }
    print code "///< " text
  }
}
END { if (FILENAME ~ /assur\.hpp$/) print "/// @namespace assur\n/// All types and functions of the library." }

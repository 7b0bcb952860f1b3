// The name itself first, also in words, then guides, then modules, classes and functions,
// and attributes last.
{
  const found = window.pdocSearch;
  const place = ({ qualname = "", kind, modulename }, name) =>
    qualname.toLowerCase() === name
      ? 0
      : !modulename.startsWith("pymunk_dragon")
        ? 1
        : kind !== "variable"
          ? 2
          : 3;
  const named = (term) => term.trim().toLowerCase().replace(/\s+/g, "_");
  window.pdocSearch = (term) =>
    found(term).sort((a, b) => place(a.doc, named(term)) - place(b.doc, named(term)));
}

// The name itself first, then guides, then modules, classes and functions, and attributes last.
{
    const found = window.pdocSearch;
    const place = ({ qualname, kind, modulename }, term) =>
        qualname === term ? 0 : !modulename.startsWith("pymunk_dragon") ? 1 : kind !== "variable" ? 2 : 3;
    window.pdocSearch = term => found(term).sort((a, b) => place(a.doc, term) - place(b.doc, term));
}

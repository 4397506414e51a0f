// The elements of the page.

export const $ = (id) => document.getElementById(id);
export const canvas = $("picture");

// What is being drawn, kept over a reload of the tab: what is half drawn has cost work too.

function keyOf({ disk }) {
  return `pianta draft ${location.pathname} ${disk.name}`;
}

// draft: an object of JSON, or null when nothing is being drawn.
export function keepDraft(session, draft) {
  try {
    if (draft) sessionStorage.setItem(keyOf(session), JSON.stringify(draft));
    else sessionStorage.removeItem(keyOf(session));
  } catch {
    // The store of the browser is full or off: a reload loses the draft.
  }
}

export function readDraft(session) {
  try {
    return JSON.parse(sessionStorage.getItem(keyOf(session)));
  } catch {
    return null;
  }
}
